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
  Eigen::VectorXd coefficients;  ///< [m]; minimum norm where the rank is short
  Eigen::VectorXd
      coefficient_std;         ///< [m]; residuals are correlated over some points, and that is allowed for
  Eigen::MatrixXd covariance;  ///< [m^2], terms x terms
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
MapFitResult fit_map(const HeightMap& map, const TermSet& terms, const MapFitOptions& options = {});

}  // namespace aberfit
