#pragma once
#include <string>

#include "aberfit/theory/regime.h"

namespace aberfit {

/// Radii in the focus by one model [m] (PHYSICS 7).
struct ModelRadii {
  double ee50 = 0, ee90 = 0, ee80 = 0;
};
/// Radii by wave optics (GHS) and by rays. Errors are rays / GHS - 1.
struct ModelErrors {
  ModelRadii ghs, rays;
  double ray_ee50 = 0, ray_ee90 = 0;
};

struct ModelChoice {
  FocusModel model = FocusModel::kWaves;
  ModelErrors errors;  ///< NaN where GHS does not exist
  /// Largest error of geometric rays against wave optics (ray_error_in_light), relative to the margin. It
  /// covers fractions from 20 to 95 % and planes up to five depths of focus. If it exceeds `allowed`, it is
  /// that of the first such plane. Infinite where there are no rays, NaN where GHS does not exist.
  double ray_error = 0;
  double allowed = 0;  ///< the limit given by the caller
  std::string reason;  ///< one sentence
};

/// Largest depth of focus, over the focal length, in which planes beside the focus are counted. It keeps them
/// within half the focal length, in front of the mirror and in a field of view that is not much smaller.
inline constexpr double kDeepestUnit = 0.1;

/// The model that a scene needs (PHYSICS 7): rays where their error against wave optics is at most `allowed`,
/// relative to the margin; else waves. Costs one to a few planes of GHS.
ModelChoice choose_model(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength, double allowed);

}  // namespace aberfit
