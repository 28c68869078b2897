#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// P = r/(1 + (r/2f)^2) [m]: f times the sine of the angle under which light from the distance r [m] of a
/// parabola's axis meets it at the focus. r for an infinite f.
double direction_of(double radius, double focal_length);

/// The aperture in the plane of P: circles stay circles; straight edges, which become arcs of ellipses, are
/// broken into chords of at most `chord` [m] before they are bent.
Aperture in_directions(const Aperture& aperture, double focal_length, double chord);

/// Clear share of a cell, and the centre of the clear part from the cell's centre times that share, in
/// pitches.
struct ClearPart {
  double share = 0, x = 0, y = 0;
};

/// The common parts of an aperture and the cells about (x[column], y[row]), exactly.
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
  std::vector<Moments> raster_;  // of outlines only: row after row
  std::vector<Moments> carried_;
};

}  // namespace aberfit::internal
