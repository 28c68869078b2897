#pragma once
#include <string>

#include "aberfit/theory/regime.h"

namespace aberfit {

/// Radii in the focus by one model [m] (PHYSICS 7).
struct ModelRadii {
  double ee50 = 0, ee90 = 0, ee80 = 0;
};
/// What each theory makes of a scene. Errors are rays / GHS - 1.
struct ModelErrors {
  ModelRadii ghs, rays;
  double ray_ee50 = 0, ray_ee90 = 0;
};

struct ModelChoice {
  FocusModel model = FocusModel::kWaves;
  ModelErrors errors;  ///< NaN where GHS does not exist
  /// Largest error of geometric rays in light, relative as a margin is (ray_error_in_light), over fractions
  /// from 20 to 95 % and planes up to five depths of focus; where it is above `allowed`, of the first plane
  /// it is so in. Infinite where there are no rays, NaN where GHS does not exist.
  double ray_error = 0;
  double allowed = 0;  ///< as asked
  std::string reason;  ///< one sentence
};

/// Depth of focus that planes beside the focus are counted in, at most, over the focal length: that they lie
/// within half of it, in front of the mirror and in a field of view that is not much smaller.
inline constexpr double kDeepestUnit = 0.1;

/// A third of the usual margin of 1 %: what `allowed` is where no study gives a margin.
inline constexpr double kUsualAllowedError = 0.01 / 3;

/// The model a scene needs (PHYSICS 7): rays where their error against light is at most `allowed`, relative
/// as a margin is; else waves. Costs a few planes of GHS where rays are nearly right, one where they are not.
ModelChoice choose_model(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength, double allowed);

}  // namespace aberfit
