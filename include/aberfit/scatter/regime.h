#pragma once
#include <string>

#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// Dimensionless numbers of a scene that say which model it needs (PHYSICS 7).
struct SceneNumbers {
  double rms_height = 0;          ///< [m]
  double rms_slope_per_axis = 0;
  double correlation_length = 0;  ///< [m]
  double n_eff = 0;               ///< modes that carry the slope
  double g = 0;                   ///< 4 pi sigma / lambda
  double kappa = 0;               ///< how nearly quadratic the structure function is where it matters; >= 0.85: rays are right
  double tis = 0;                 ///< total integrated scatter 1 - exp(-g^2)
  double paper_ratio_r = 0;       ///< 2 sigma D / (1.22 lambda l_c): shown, decides nothing
  double realisation_spread = 0;  ///< 0.65 / sqrt(n_eff): relative spread of ee90 between draws
  double airy_ee90 = 0;           ///< 1.9014 lambda f / D [m] (full circle)
  bool rays_are_valid = false;    ///< kappa >= kKappaOfRays and ray ee90 >= 5 Airy ee90
  std::string reason;             ///< one sentence
};

/// kappa from which the ray ee90 and ee50 are within 10 % of GHS (PHYSICS 7, golden/ghs_ee.csv).
inline constexpr double kKappaOfRays = 0.85;

SceneNumbers scene_numbers(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture, double wavelength);

}  // namespace aberfit
