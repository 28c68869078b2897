#include "focal_frame.h"

#include <algorithm>
#include <cmath>

namespace aberfit::internal {

double spot_scale(double core_sigma, std::initializer_list<const FocalLight*> lights) {
  if (core_sigma > 0) return core_sigma;
  for (const FocalLight* light : lights)
    if (light)
      if (const double ee50 = light->statistic(EncircledEnergyRadius{0.5, 0.0}); ee50 > 1e-12)
        return ee50 / std::sqrt(2 * std::log(2.0));
  return 1e-6;
}

double curve_end(const FocalLight& light, double dz) {
  const double ee98 = light.statistic(EncircledEnergyRadius{0.98, dz});
  const double most = 2 * light.statistic(EncircledEnergyRadius{0.9, dz});
  return ee98 < most ? ee98 : most;
}

double image_half_width(double ee90, double scale) {
  // In units of the spot's sigma we take 2 for the blur of defocus and 3 for the spot, and more for a halo,
  // which is wide and faint.
  constexpr double kHalfWidth = 5, kWidest = 25, kHaloMargin = 1.35;
  // NaN: a spot without light
  const double wanted = std::isfinite(ee90) ? kHaloMargin * ee90 / scale : 0;
  return std::clamp(wanted, kHalfWidth, kWidest) * scale;
}

}  // namespace aberfit::internal
