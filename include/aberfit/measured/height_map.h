#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/core/warning.h"

namespace aberfit {

/// A matrix of values, stored row after row.
using Grid = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Surface heights on a regular grid. Readers convert a measured wavefront to the surface by halving it.
struct HeightMap {
  Grid height;  ///< [m]; (row, column), row 0 at the lowest y; NaN where there is no valid measurement
  double pitch_x = 0, pitch_y = 0;  ///< distance of columns and of rows [m]; 0: the file does not state it
  double x0 = 0, y0 = 0;            ///< position of (row 0, column 0) [m]
  std::string label;                ///< description in the file; may be empty
  Warnings warnings;                ///< choices of the reader that the file leaves open
  double file_unit = 1;             ///< surface height that corresponds to a value of 1 in the file [m]
  Eigen::Index said_invalid = 0;    ///< number of points that have a value of MeasuredSource::invalid

  Eigen::Index rows() const { return height.rows(); }
  Eigen::Index columns() const { return height.cols(); }
  double x(Eigen::Index column) const { return x0 + pitch_x * double(column); }
  double y(Eigen::Index row) const { return y0 + pitch_y * double(row); }
};

/// Returns the number of points with a value.
Eigen::Index valid_count(const HeightMap& map);

/// Moves the origin to the middle of the grid.
void centre_on_grid(HeightMap* map);

/// Smallest circle that holds every valid point; lengths [m].
struct Circle {
  double x = 0, y = 0, radius = 0;
};
Circle enclosing_circle(const HeightMap& map);

/// Moves the origin to (x, y), given in the present coordinates of the map [m].
void move_origin(HeightMap* map, double x, double y);

}  // namespace aberfit
