#pragma once
#include <Eigen/Core>
#include <optional>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Order of the polynomials that a term surface is made of within `reach` [m] of the axis: the highest n of
/// the Zernikes, the highest spherical power, and of a wave of k = 2 pi f reach radians the order k + 6.3
/// k^(1/3) + 4, beyond which its expansion's terms, Bessel functions J_n(2k) for the square, are below 1e-12
/// (DLMF 10.19.8). At most 1e8.
int polynomial_order(const TermSet& terms, double reach);

/// Points of the whole aperture, margin not taken off, on which sums over height and slope of a term surface,
/// and over their squares, are integrals over the aperture, whatever grid its light is computed on:
/// quadrature_pupil for twice the order of the terms, and 24 degrees more for the mirror under them, whose
/// (1 + t^2)^-2, t the slope of the mirror, turns slopes into angles; from f/1 on that is below 1e-12.
/// Relative error for n <= 60 below 1e-11 for RMS height and slope (tests/forward/term_moments_test.cpp); the
/// RMS angle between rays adds terms of fourth order, a share of the order of the slope squared.
/// Nothing where it takes more than kMostMomentPoints, as for waves of more than 600 cycles across: there
/// the points that see the light have to do.
std::optional<PupilSample> moment_pupil(const Aperture& aperture, const TermSet& terms);
inline constexpr double kMostMomentPoints = 1 << 22;

/// The same rule made finer, to about nine times the points of one on a circle, for the mean angle of
/// scatter: that has a kink wherever the slope vanishes, and no rule is exact for it. Relative error, root
/// mean square over surfaces: kMeanAngleError; up to five times that was seen where a few high orders make up
/// the surface. Only as fine as kMostMomentPoints allow; nothing where moment_pupil is nothing.
std::optional<PupilSample> mean_angle_pupil(const Aperture& aperture, const TermSet& terms);
inline constexpr double kMeanAngleError = 1e-4;

/// The numbers of a term surface over an aperture, margin not taken off.
struct TermMoments {
  double rms_height = 0;          ///< about the mean [m]
  double rms_slope_per_axis = 0;  ///< root of half the mean square of the gradient
};
/// The sums over points whose weights sum to 1.
TermMoments moments_of(const SurfaceField& field, const Eigen::ArrayXd& weight);
/// Exact for the order of the terms; nothing where moment_pupil is nothing.
std::optional<TermMoments> term_moments(const Aperture& aperture, const TermSet& terms,
                                        const Eigen::VectorXd& coefficients, int threads = 1);

}  // namespace aberfit
