#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// P = r/(1 + (r/2f)^2) [m]: f times the sine of the angle at the focus of a ray from distance r [m] of a
/// parabola's axis. It is r for an infinite f.
double direction_of(double radius, double focal_length);

/// The aperture in the plane of P. Circles stay circles. Straight edges become arcs of ellipses, so they are
/// first divided into chords of at most `chord` [m].
Aperture in_directions(const Aperture& aperture, double focal_length, double chord);

/// Clear fraction of a grid cell. x, y: centroid of the clear part from the cell's centre, times that
/// fraction, in pitches.
struct ClearPart {
  double share = 0, x = 0, y = 0;
};

/// The exact intersections of an aperture with the grid cells about (x[column], y[row]).
class ApertureCells {
 public:
  ApertureCells(const Aperture& aperture, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y, double pitch_x,
                double pitch_y);
  ClearPart operator()(Eigen::Index column, Eigen::Index row) const;

 private:
  // Area and first moments about the lower left corner, in pitches.
  struct Moments {
    double area = 0, x = 0, y = 0;
    void add(double sign, const Moments& m) {
      area += sign * m.area;
      x += sign * m.x;
      y += sign * m.y;
    }
  };
  void rasterise(const std::vector<Outline>& outlines);
  void add_edge(double u0, double v0, double u1, double v1);
  void add_in_row(Eigen::Index row, double u0, double v0, double u1, double v1);

  const Aperture& aperture_;
  const Eigen::ArrayXd &x_, &y_;
  double pitch_x_, pitch_y_;
  std::vector<Moments> raster_;  // row after row; used only for outlines
  std::vector<Moments> carried_;
};

}  // namespace aberfit::internal
