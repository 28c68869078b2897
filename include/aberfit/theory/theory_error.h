#pragma once
#include <string>
#include <vector>

#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"

namespace aberfit {

/// Fraction of the energy beyond 10 degrees up to which generalised Harvey-Shack is used without a warning.
inline constexpr double kMostBeyondTenDegrees = 1e-3;
/// Fraction from which the theory does not apply: the default range of 95 % of the energy reaches there.
inline constexpr double kTooMuchBeyondTenDegrees = 0.05;
/// Part of the energy beyond 10 degrees that the neglected obliquity factor and polarisation may move. It is
/// sin^2 of 30 degrees, the largest angle of use.
inline constexpr double kObliquity = 0.25;
/// Wavelength [m] below which mirrors mostly work at grazing, not at normal, incidence.
inline constexpr double kShortestAtNormalIncidence = 30e-9;

/// Errors of generalised Harvey-Shack in a scene, as numbers (PHYSICS 6).
struct TheoryError {
  /// Relative error of EE radii in the paraxial form only, 1/(32 N^2), N = f / (2 R).
  double paraxial = 0;
  /// Relative error of the radius with 90 % of the scattered energy when the sine of the angle replaces its
  /// tangent, sin^2 / 2. Infinity where less than 90 % leaves the surface below 90 degrees.
  double small_angle = 0;
  double beyond_ten_degrees = 0;  ///< fraction of the total energy scattered beyond 10 degrees
  double cut_share = 0;           ///< fraction of the height variance above 1/lambda, which does not scatter
  bool applies = false;           ///< beyond_ten_degrees <= kTooMuchBeyondTenDegrees
  bool wide_angles = false;       ///< the theory applies, but beyond_ten_degrees > kMostBeyondTenDegrees
  bool mostly_grazing = false;    ///< wavelength < kShortestAtNormalIncidence
  std::string clause;             ///< why the theory does not apply, or its main limit; no full stop
  std::string of_grazing;         ///< warning for short wavelengths; no full stop
};
/// wavelength > 0 [m]. The angles are those of a mirror without edges: exp(-E) times a Gaussian 300 lambda
/// wide. So diffraction at the aperture does not count; error of the fractions 1e-6. Takes milliseconds.
/// Throws ComputationError where the structure function is infinite.
TheoryError theory_error(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength);

/// Largest error of geometric rays against wave optics over the fractions and planes (dz [m]), in tolerances
/// of a margin of 1 (PHYSICS 7). The error is |E_rays(r_p) - p| / max(r dE/dr, 0.35). In wave optics the
/// radius r_p has the fraction p and the slope dE/dr. Rays suffice below a third of a study's margin.
/// Infinity for infinite radii.
double ray_error_in_light(const GeneralisedHarveyShack& light, const GeometricHarveyShack& rays,
                          const std::vector<double>& fractions, const std::vector<double>& planes);

}  // namespace aberfit
