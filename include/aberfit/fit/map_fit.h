#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "aberfit/core/warning.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

enum class MapWeighting {
  kArea,  ///< weight by the point's grid cell and part of the holes beside it, so that dropouts hardly matter
  kPoints,  ///< equal weights
};

struct MapFitOptions {
  MapWeighting weighting = MapWeighting::kArea;
  double held_out = 0.1;  ///< fraction of the valid points held out, chosen by seed
  std::uint64_t seed = 1;
  int threads = 1;
};

/// A plane, height + slope_x x + slope_y y [m] about the map's origin.
struct MapPlane {
  double height = 0;  ///< [m]
  double slope_x = 0, slope_y = 0;

  double operator()(double x, double y) const { return height + slope_x * x + slope_y * y; }
};

struct MapFitResult {
  enum class Status { kNotRun, kConverged, kRankDeficient, kFailed } status = Status::kNotRun;
  std::string message;
  Eigen::VectorXd coefficients;     ///< [m]; minimum norm where the rank is short
  Eigen::VectorXd coefficient_std;  ///< [m]; assumptions: see fit_map
  Eigen::MatrixXd covariance;       ///< [m^2], terms x terms
  MapPlane mount;                   ///< piston and tilt that the set lacks: fitted as well, then dropped
  int rank = 0;
  double condition_number = 0;  ///< of the column-scaled design
  Eigen::Index points = 0, held_out_points = 0;
  double rms_map = 0;             ///< RMS of the valid points about their mean [m]
  double rms_residual = 0;        ///< over the fitted points [m]
  double rms_held_out = 0;        ///< over the held-out points [m]
  double independent_points = 0;  ///< effective number of independent residuals
  Warnings warnings;
};

/// Least-squares terms of a map on any mask. All terms are fitted jointly (on a mask they are not
/// orthogonal), with one row per valid point within terms.radius of the origin. Piston and tilt are fitted as
/// well where the set lacks them, and then dropped.
/// Standard deviations come from the residual in the orders next beyond the terms. These are the fewest whole
/// orders that have 40 Zernike modes, orthonormalised beside the terms on the points. Components above four
/// standard deviations are figure that the terms leave. The mean square v of the others is a density: the
/// variance of white noise, or the power of correlated noise and roughness just beyond the terms. cov(c) = v
/// (A^T A)^-1 + d d^T, with d the part of that figure in the terms, as the points do not separate the two.
/// Assumption: noise and unmodelled surface have the same density in the orders of the terms. High-frequency
/// roughness leaks into these modes as it does into the terms. Roughness that rises towards low orders is
/// part of this surface, and std does not count it as an error of the terms.
MapFitResult fit_map(const HeightMap& map, const TermSet& terms, const MapFitOptions& options = {});

}  // namespace aberfit
