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

/// Largest error against GHS, of ee50 and of ee90, with which geometric rays are accepted (PHYSICS 7, rule
/// 1).
inline constexpr double kErrorOfRays = 0.10;

struct ModelChoice {
  FocusModel model = FocusModel::kWaves;
  ModelErrors errors;  ///< NaN where GHS does not exist (infinite structure function)
  std::string reason;  ///< one sentence
};

/// Errors of geometric rays (GeometricHarveyShack) against generalised Harvey-Shack, both aperture-exact and
/// of this mirror and this aperture. Infinite for rays of an infinite slope. Throws ComputationError as
/// GeneralisedHarveyShack does. Costs milliseconds to tenths of a second (power laws, polygons). See
/// `ray_error_in_light` for the same in light.
ModelErrors model_errors(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength);

/// The model a scene needs. kappa >= kKappaOfRays and ray ee90 >= kAiryRadiiForRays Airy ee90 admit rays,
/// which must then agree with GHS within the error above; all else is for waves. Evidence, test ModelChoice,
/// 532 scenes: the thresholds alone let no error above 10 % pass (worst 8.7 %); comparing keeps the promise
/// for spectra outside that grid, too. R >= 1000 is 10 % wrong on ee90 in 5 of its 28 scenes, by
/// up to a factor 1600 on ee50.
ModelChoice choose_model(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength);

}  // namespace aberfit
