#include "aberfit/core/root.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>

#include "aberfit/core/constants.h"

namespace aberfit {

double root_between(const std::function<double(double)>& f, double a, double b, double fa, double fb,
                    double tolerance) {
  if (fa == 0) return a;
  if (fb == 0) return b;
  if (b < a) return root_between(f, b, a, fb, fa, tolerance);
  std::uintmax_t iterations = 200;
  const auto close = [&](double low, double high) {
    return high - low <= tolerance * std::min(std::abs(low), std::abs(high));
  };
  const auto bracket = boost::math::tools::toms748_solve(f, a, b, fa, fb, close, iterations);
  return 0.5 * (bracket.first + bracket.second);
}

double first_crossing(const std::function<double(double)>& f, double from, double f_from, double step,
                      double limit, double tolerance) {
  for (double here = from, f_here = f_from;;) {
    const double next = here + step;
    if (std::abs(next) > limit) return kNaN;
    const double f_next = f(next);
    if (f_next <= 0) return root_between(f, here, next, f_here, f_next, tolerance);
    here = next;
    f_here = f_next;
  }
}

}  // namespace aberfit
