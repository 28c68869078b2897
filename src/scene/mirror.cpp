#include "aberfit/scene/mirror.h"

#include <algorithm>
#include <limits>

namespace aberfit {

bool is_parabola(const Mirror& mirror) {
  return mirror.conic == -1.0 &&
         std::all_of(mirror.spherical.begin(), mirror.spherical.end(), [](double c) { return c == 0.0; }) &&
         std::all_of(mirror.zernike.begin(), mirror.zernike.end(),
                     [](const KnownZernike& term) { return term.height == 0.0; });
}

bool is_rotationally_symmetric(const Mirror& mirror) {
  return std::all_of(mirror.zernike.begin(), mirror.zernike.end(),
                     [](const KnownZernike& term) { return term.mode.m == 0 || term.height == 0.0; });
}

Mirror without_known_zernikes(Mirror mirror) {
  mirror.zernike.clear();
  return mirror;
}

double sag_domain_radius(const Mirror& mirror) {
  if (mirror.conic <= -1.0) return std::numeric_limits<double>::infinity();
  return 2.0 * mirror.focal_length / std::sqrt(1.0 + mirror.conic);
}

}  // namespace aberfit
