#pragma once
#include <string>
#include <vector>

#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"

namespace aberfit {

/// Share of the light scattered beyond 10 degrees that generalised Harvey-Shack leaves without a word.
inline constexpr double kMostBeyondTenDegrees = 1e-3;
/// The share from which it does not apply: what is judged by default, 95 % of the light, would reach there.
inline constexpr double kTooMuchBeyondTenDegrees = 0.05;
/// Of the light beyond 10 degrees, the part that the obliquity factor and polarisation, which are left out,
/// may move: sin^2 of 30 degrees, as far as it is used (`angle_spread`).
inline constexpr double kObliquity = 0.25;
/// Wavelength below which mirrors are mostly used at grazing incidence, not at the normal one meant here [m].
inline constexpr double kShortestAtNormalIncidence = 30e-9;

/// What generalised Harvey-Shack leaves out in a scene, as numbers (PHYSICS 6).
struct TheoryError {
  /// Relative error of EE radii in the paraxial form, 1/(32 N^2), N = f / (2 R); the aperture-exact form has
  /// none of it.
  double paraxial = 0;
  /// Relative error of the radius that holds 90 % of the scattered light by taking the sine of the angle for
  /// its tangent, sin^2 / 2; infinity where less than 90 % leaves the surface below 90 degrees.
  double small_angle = 0;
  double beyond_ten_degrees = 0;  ///< share of all light that the roughness scatters beyond 10 degrees
  double cut_share = 0;           ///< of the height variance, at frequencies above 1/lambda: does not scatter
  bool applies = false;           ///< beyond_ten_degrees <= kTooMuchBeyondTenDegrees
  bool wide_angles = false;       ///< it applies, and beyond_ten_degrees > kMostBeyondTenDegrees
  bool mostly_grazing = false;    ///< wavelength < kShortestAtNormalIncidence
  std::string clause;             ///< why it does not apply, or what to mind first; no full stop
  std::string of_grazing;         ///< what to mind at short wavelengths; no full stop
};
/// wavelength > 0 [m]. The angles are those of a mirror without edges: exp(-E) times a Gaussian 300 lambda
/// wide, so that diffraction at the aperture counts for nothing; error of the shares 1e-6. Costs
/// milliseconds. Throws ComputationError where the structure function is infinite.
TheoryError theory_error(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength);

/// Largest error of geometric rays in light over the fractions and planes (dz [m]), in tolerances of a margin
/// of 1 (PHYSICS 7): |E_rays(r_p) - p| / max(r dE/dr, 0.35), r_p the radius that holds the fraction p in
/// light and dE/dr its slope there. Below a third of a study's margin rays will do. Infinity where a radius
/// is not finite.
double ray_error_in_light(const GeneralisedHarveyShack& light, const GeometricHarveyShack& rays,
                          const std::vector<double>& fractions, const std::vector<double>& planes);

}  // namespace aberfit
