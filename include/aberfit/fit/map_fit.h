#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "aberfit/core/warning.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

enum class MapWeighting {
  kArea,  ///< a point stands for its own cell and its share of the holes beside it, so that it hardly matters
          ///< which pixels dropped out
  kPoints,  ///< all points alike
};

struct MapFitOptions {
  MapWeighting weighting = MapWeighting::kArea;
  double held_out = 0.1;  ///< share of the valid points kept back, drawn by seed
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
  Eigen::VectorXd coefficient_std;  ///< [m]; what it assumes stands at fit_map
  Eigen::MatrixXd covariance;       ///< [m^2], terms x terms
  MapPlane mount;  ///< piston and tilt that were fitted along where the set lacks them, and dropped
  int rank = 0;
  double condition_number = 0;  ///< of the column-scaled design
  Eigen::Index points = 0, held_out_points = 0;
  double rms_map = 0;             ///< of the valid points about their mean [m]
  double rms_residual = 0;        ///< over the fitted points [m]
  double rms_held_out = 0;        ///< over the points kept back [m]
  double independent_points = 0;  ///< effective number of independent residuals
  Warnings warnings;
};

/// Least-squares terms of a map on any mask: all terms jointly (on a mask they are not orthogonal), one row
/// per valid point within terms.radius of the origin. Piston and tilt are fitted along where the set lacks
/// them and then dropped.
/// Standard deviations are from what the residuals hold in the orders next beyond the terms, along the fewest
/// whole orders of Zernike modes with 40 of them, orthonormalised beside the terms on the points. Components
/// that stand out of the others by more than four standard deviations are figure that the terms leave; the
/// mean square v of the others is a density: of white noise its variance, of correlated noise and of
/// roughness their power just beyond the terms. cov(c) = v (A^T A)^-1 + d d^T, d: what of that figure the
/// terms have taken along, as the points do not tell both apart. It is assumed that what the terms do not
/// stand for has the same density in their own orders. Roughness of higher frequencies alone leaks into these
/// modes as it does into the terms; of roughness that rises towards low orders the terms hold that of this
/// very surface, which std does not count as their error.
MapFitResult fit_map(const HeightMap& map, const TermSet& terms, const MapFitOptions& options = {});

}  // namespace aberfit
