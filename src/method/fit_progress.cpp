#include "fit_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/method/constants.h"

namespace aberfit::internal {

double seconds_left(const FitProgress& first, const FitProgress& last) {
  const int done = last.iteration - first.iteration;
  const double fall = std::log(first.worst_mismatch / last.worst_mismatch);
  if (done < 1 || !(fall > 0)) return std::nan("");
  const double iterations = std::max(0.0, done * std::log(last.worst_mismatch) / fall);
  return iterations * (last.seconds - first.seconds) / done;
}

FitProgressLine::FitProgressLine(Eigen::Index terms, int set, int most, int start)
    : set_(fmt::format("set {}{}, {} terms{}", set, most > 0 ? fmt::format(" of at most {}", most) : "",
                       terms, start > 0 ? fmt::format(", start {}", start + 1) : "")) {
  first_.solve = -1;
}

std::string FitProgressLine::operator()(const FitProgress& p) {
  if (p.solve != first_.solve) first_ = p;
  std::string line = fmt::format("fit: {}; iteration {}, largest mismatch {:.3g} tolerances, {:.1f} s", set_,
                                 p.iteration, p.worst_mismatch, p.seconds);
  if (p.iteration == first_.iteration) return line;
  const double left = seconds_left(first_, p);
  if (p.iteration < law::kFewIterations && !std::isfinite(left)) {
    const double each = p.seconds / p.iteration;
    return line + fmt::format(", probably {:.2g} to {:.2g} s in all", law::kFewIterations * each,
                              law::kManyIterations * each);
  }
  // The remaining iterations at this rate are more than fits usually take.
  const double each = (p.seconds - first_.seconds) / (p.iteration - first_.iteration);
  if (!(left <= law::kManyIterations * each)) return line + ", end not foreseeable";
  return line + fmt::format(", probably {:.2g} s in all", p.seconds + left);
}

}  // namespace aberfit::internal
