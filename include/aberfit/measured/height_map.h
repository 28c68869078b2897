#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/core/warning.h"

namespace aberfit {

/// Rows by columns, row after row in memory.
using Grid = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Surface heights on a regular grid. Always the surface: readers halve what was measured on a wavefront.
struct HeightMap {
  Grid height;  ///< [m]; (row, column), row 0 at the lowest y; NaN where there is no valid measurement
  double pitch_x = 0, pitch_y = 0;  ///< distance of columns and of rows [m]; 0: the file does not say
  double x0 = 0, y0 = 0;            ///< position of (row 0, column 0) [m]
  std::string label;                ///< what the file says it is; may be empty
  Warnings warnings;                ///< what its reader chose where the file leaves a choice
  double file_unit = 1;             ///< a value of 1 in the file is this height of the surface [m]
  Eigen::Index said_invalid = 0;    ///< points that are holes because MeasuredSource::invalid has their value

  Eigen::Index rows() const { return height.rows(); }
  Eigen::Index columns() const { return height.cols(); }
  double x(Eigen::Index column) const { return x0 + pitch_x * double(column); }
  double y(Eigen::Index row) const { return y0 + pitch_y * double(row); }
};

/// Number of points with a value.
Eigen::Index valid_count(const HeightMap& map);

/// Moves the origin to the middle of the grid.
void centre_on_grid(HeightMap* map);

/// Smallest circle that holds every valid point [m].
struct Circle {
  double x = 0, y = 0, radius = 0;
};
Circle enclosing_circle(const HeightMap& map);

/// Moves the origin to (x, y), in the map's present coordinates.
void move_origin(HeightMap* map, double x, double y);

}  // namespace aberfit
