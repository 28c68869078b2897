#include "bessel_orders.h"

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>

namespace aberfit::internal {

void bessel_j_orders(double x, int top, double* values) {
  if (x > top && top >= 1) {
    values[0] = boost::math::cyl_bessel_j(0, x);
    values[1] = boost::math::cyl_bessel_j(1, x);
    for (int k = 1; k < top; ++k) values[k + 1] = 2 * k / x * values[k] - values[k - 1];
    return;
  }
  // Ten Airy lengths (top/2)^(1/3) beyond the turning point, the wrong solution is 18 digits smaller.
  const int start = std::max(top, int(x)) + 20 + int(8 * std::cbrt(std::max(top + 1.0, x)));
  double above = 0, here = 1e-280, even_sum = 0;
  std::fill(values, values + top + 1, 0.0);
  for (int k = start; k >= 0; --k) {
    if (k <= top) values[k] = here;
    if (k % 2 == 0) even_sum += k == 0 ? here : 2 * here;
    const double below = 2 * k / x * here - above;
    above = here;
    here = below;
    if (std::abs(here) > 1e250) {
      above *= 1e-250;
      here *= 1e-250;
      even_sum *= 1e-250;
      for (int i = k; i <= top; ++i) values[i] *= 1e-250;
    }
  }
  for (int k = 0; k <= top; ++k) values[k] /= even_sum;  // J_0 + 2 J_2 + 2 J_4 + ... = 1
}

}  // namespace aberfit::internal
