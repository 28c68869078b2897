#pragma once
#include <string>

#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// Dimensionless numbers of a scene that decide which model it needs (PHYSICS 7).
struct SceneNumbers {
  double rms_height = 0;           ///< RMS height of the whole PSD [m]; may be infinite
  double relevant_rms_height = 0;  ///< over the frequencies below 1/lambda, which alone scatter [m]
  double cut_share = 0;            ///< fraction of the height variance above 1/lambda
  double rms_slope_per_axis = 0;
  double correlation_length = 0;  ///< [m]
  double n_eff = 0;               ///< number of modes that carry the slope; 0 when the slope is infinite
  double g = 0;                   ///< 4 pi sigma / lambda, sigma = relevant_rms_height
  double kappa = 0;               ///< how quadratic the structure function is; rays are right from 0.85 on
  /// Total integrated scatter at normal incidence, 1 - exp(-g^2): the fraction of the mirror's energy that
  /// its roughness scatters. Methods that predict the spot replace it by the value with the incidence of
  /// every point of the aperture (`GeneralisedHarveyShack::tis`).
  double tis = 0;
  double paper_ratio_r = 0;  ///< 2 sigma D / (1.22 lambda l_c); shown only, it decides nothing
  double airy_ee90 =
      0;  ///< ee90 of the perfect mirror by diffraction [m]; 1.900688 lambda f / D for a full circle
  bool kappa_rule_allows_rays = false;  ///< kappa >= kKappaOfRays and ray ee90 >= 5 Airy ee90
  std::string reason;                   ///< one sentence
};

/// kappa from which ee90 and ee50 of rays are within 10 % of GHS (PHYSICS 7, tests/data/golden/ghs_ee.csv).
inline constexpr double kKappaOfRays = 0.85;
/// Ratio of the ray ee90 to the Airy ee90 from which diffraction does not show (PHYSICS 7).
inline constexpr double kAiryRadiiForRays = 5;

/// ee90 of the perfect mirror by diffraction [m]. Full circle: 1.900688 lambda f / D, from 1 - J0(v)^2 -
/// J1(v)^2 = 0.9, v = pi D r / (lambda f) (Born and Wolf 8.5.2). Others from their OTF, relative error 1e-8;
/// polygons 1e-4.
double airy_ee90(const Mirror& mirror, const Aperture& aperture, double wavelength);

/// Numbers of a roughness on a mirror, wavelength > 0 [m]. kappa = E(x1), E(x) = (4 pi/lambda)^2 (C(0) -
/// C(x)), x1 = sqrt2 lambda/(4 pi slope). The ray ee90 is the paraxial one of convention `physical`, 2.146 *
/// 2 f slope. Infinite slope variance: kappa is 0, kappa_rule_allows_rays is false and `reason` names the
/// cause. Infinite height variance at low frequency: g is infinite, R and l_c are 0, and kappa comes from the
/// structure function (NaN where that is infinite, too).
SceneNumbers scene_numbers(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                           double wavelength);

/// The model by the thresholds on kappa and spot size. `choose_model` also compares with wave optics.
FocusModel regime(const SceneNumbers& numbers);

}  // namespace aberfit
