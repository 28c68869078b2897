#pragma once
#include <string>

#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// Dimensionless numbers of a scene that say which model it needs (PHYSICS 7).
struct SceneNumbers {
  double rms_height = 0;           ///< of the whole PSD [m]; may be infinite
  double relevant_rms_height = 0;  ///< of the frequencies below 1/lambda, which alone scatter light [m]
  double cut_share = 0;            ///< share of the height variance above them
  double rms_slope_per_axis = 0;
  double correlation_length = 0;  ///< [m]
  double n_eff = 0;               ///< modes that carry the slope; 0 when the slope is infinite
  double g = 0;                   ///< 4 pi sigma / lambda, sigma = relevant_rms_height
  double kappa =
      0;  ///< how nearly quadratic the structure function is where it matters; >= 0.85: rays are right
  /// Total integrated scatter, the share of the mirror's light that its roughness scatters: 1 - exp(-g^2) of
  /// normal incidence; the steps of a method that predict the light put the mirror's own in its place, with
  /// the incidence of every point of the aperture (`GeneralisedHarveyShack::tis`).
  double tis = 0;
  double paper_ratio_r = 0;  ///< 2 sigma D / (1.22 lambda l_c): shown, decides nothing
  double airy_ee90 =
      0;  ///< of the perfect mirror by diffraction [m]; 1.900688 lambda f / D for a full circle
  bool kappa_rule_allows_rays = false;  ///< kappa >= kKappaOfRays and ray ee90 >= 5 Airy ee90
  std::string reason;                   ///< one sentence
};

/// kappa from which the ray ee90 and ee50 are within 10 % of GHS (PHYSICS 7, tests/data/golden/ghs_ee.csv).
inline constexpr double kKappaOfRays = 0.85;
/// Ray ee90 over Airy ee90 from which diffraction does not show (PHYSICS 7).
inline constexpr double kAiryRadiiForRays = 5;

/// ee90 of the perfect mirror by diffraction [m]. Full circle: 1.900688 lambda f / D, from 1 - J0(v)^2 -
/// J1(v)^2 = 0.9, v = pi D r / (lambda f) (Born and Wolf 8.5.2). Annuli and rectangles: from their own OTF,
/// relative error below 1e-8; polygons 1e-4.
double airy_ee90(const Mirror& mirror, const Aperture& aperture, double wavelength);

/// Numbers of a roughness on a mirror, wavelength > 0 [m]. kappa = E(x1), E(x) = (4 pi/lambda)^2 (C(0) -
/// C(x)), x1 = sqrt2 lambda/(4 pi slope). The ray ee90 compared is the paraxial one of convention
/// `physical`, 2.146 * 2 f slope. Where the slope variance is infinite, kappa is 0, kappa_rule_allows_rays is
/// false and the reason says so. Where the height variance is, at low frequency, g is infinite, R and l_c are
/// 0, and kappa comes from the structure function, NaN where that is infinite, too.
SceneNumbers scene_numbers(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                           double wavelength);

/// The model that the thresholds on kappa and on the size of the spot admit; `choose_model` asks, beyond
/// that, for agreement with wave optics.
FocusModel regime(const SceneNumbers& numbers);

}  // namespace aberfit
