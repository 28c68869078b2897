#pragma once
#include <Eigen/Core>
#include <optional>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Order of the polynomials that represent a term surface within `reach` [m] of the axis; at most 1e8. It is
/// the highest n of the Zernikes, the highest spherical power, or k + 6.3 k^(1/3) + 4 for a wave of k = 2 pi
/// f reach radians, whichever is largest. Beyond that order, the wave's expansion terms, Bessel functions
/// J_n(2k) for the square, are below 1e-12 (DLMF 10.19.8).
int polynomial_order(const TermSet& terms, double reach);

/// Points of the whole aperture, without its margin, for exact integrals of height and slope of a term
/// surface and of their squares. It is quadrature_pupil for twice the order of the terms, plus 24 degrees for
/// the mirror, whose factor (1 + t^2)^-2, t its slope, turns slopes into angles; from f/1 on the error of
/// that is below 1e-12. Relative error for n <= 60 below 1e-11 for RMS height and slope
/// (tests/forward/term_moments_test.cpp). The RMS angle between rays has additional terms of fourth order,
/// relative size slope^2. Empty where it needs more than kMostMomentPoints, as for waves of more than 600
/// cycles across; the points of the statistics are then used instead.
std::optional<PupilSample> moment_pupil(const Aperture& aperture, const TermSet& terms);
inline constexpr double kMostMomentPoints = 1 << 22;

/// The same rule with about nine times as many points (on a circle), for the mean scatter angle. That angle
/// has a kink wherever the slope vanishes, so no rule is exact. Relative error, root mean square over
/// surfaces: kMeanAngleError; up to five times that for surfaces of a few high orders. It has at most
/// kMostMomentPoints, and is empty where moment_pupil is empty.
std::optional<PupilSample> mean_angle_pupil(const Aperture& aperture, const TermSet& terms);
inline constexpr double kMeanAngleError = 1e-4;

/// Moments of a term surface over an aperture without its margin.
struct TermMoments {
  double rms_height = 0;          ///< about the mean [m]
  double rms_slope_per_axis = 0;  ///< root of half the mean square of the gradient
};
/// The moments from points whose weights sum to 1.
TermMoments moments_of(const SurfaceField& field, const Eigen::ArrayXd& weight);
/// The moments, exact for the order of the terms; empty where moment_pupil is empty.
std::optional<TermMoments> term_moments(const Aperture& aperture, const TermSet& terms,
                                        const Eigen::VectorXd& coefficients, int threads = 1);

}  // namespace aberfit
