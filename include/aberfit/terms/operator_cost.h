#pragma once
#include <Eigen/Core>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// How many points an operator has and how they are arranged: what its cost depends on beside the terms.
/// Counts that do not apply are zero.
struct PointLayout {
  Eigen::Index points = 0;
  Eigen::Index rings = 0;    ///< polar: rings times spokes are the points
  Eigen::Index spokes = 0;   ///< polar: points per ring
  Eigen::Index rows = 0;     ///< Cartesian grid
  Eigen::Index columns = 0;  ///< Cartesian grid
};
PointLayout point_layout(const PupilSample& pupil);

/// Predicted time of one apply and one apply_transpose on one thread [s]. A handful of operation counts times
/// constants, one set per instruction set, which tests/benchmarks/operator_benchmark measures. On the AVX-512
/// core they were fitted on within a factor of 1.5, but for stored bases just beyond the cache and for few
/// spokes of awkward primes (2 to 2.5); elsewhere good for comparing methods rather than for a clock.
struct OperatorSeconds {
  double forward = 0;
  double adjoint = 0;
};

/// Memory that a stored basis may take per family of terms [bytes].
constexpr double kDenseBytesMax = 1024.0 * 1024.0 * 1024.0;

/// The Zernike part by one method; infinite where the layout does not allow it (polar without rings, a stored
/// basis beyond kDenseBytesMax). Throws std::invalid_argument for an (n, m) that is no Zernike mode.
OperatorSeconds predicted_seconds(ZernikeMethod method, const TermSet& terms, const PointLayout& layout);
/// The Fourier part by one method, likewise.
OperatorSeconds predicted_seconds(FourierMethod method, const TermSet& terms, const PointLayout& layout);
/// All families: Zernike and Fourier as in `choice`, spherical terms point by point.
OperatorSeconds predicted_seconds(const OperatorChoice& choice, const TermSet& terms,
                                  const PointLayout& layout);

/// The method with the smallest predicted forward plus adjoint time for each family, or the one that
/// `options` names. A function of its arguments and the processor's instruction set only: nothing is timed. A
/// stored basis is taken only where named, as nothing here tells how often it will be used. Throws
/// std::invalid_argument for a named method that the layout does not allow.
OperatorChoice choose_operator(const TermSet& terms, const PointLayout& layout,
                               const OperatorOptions& options = {});
OperatorChoice choose_operator(const TermSet& terms, const PupilSample& pupil,
                               const OperatorOptions& options = {});

/// From how many listed rays on apply_transpose is faster by scattering their weights to all points and using
/// `method` there than point by point on the listed rays.
Eigen::Index enough_rays(ZernikeMethod method, const TermSet& terms, const PointLayout& layout);
Eigen::Index enough_rays(FourierMethod method, const TermSet& terms, const PointLayout& layout);

}  // namespace aberfit
