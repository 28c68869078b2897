#pragma once
#include <array>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

/// Optical transfer function of a perfect, evenly lit aperture, averaged over direction: of circles and
/// annuli the OTF itself, of rectangles and polygons what encircled energies about the axis depend on. It is
/// a function of the pupil shear x = lambda f nu [m]; real, because OTFs at opposite shears are conjugate; 1
/// at x = 0.
class ApertureOtf {
 public:
  /// Throws ComputationError for an annulus without opening, and lengths that are not positive.
  explicit ApertureOtf(const Aperture& aperture);

  /// OTF at shear x >= 0 with a defocus of `curvature` = 2 pi dz / (lambda f^2) [rad/m^2]: the wave
  /// aberration dz rho^2 / (2 f (f + dz)) makes the phase curvature * x * u across the overlap, u along the
  /// shear. Overlap of two circles and of two annuli in closed form without defocus (O'Neill 1956), with it
  /// one integral over the angle whose cosine is u (Hopkins 1955); of rectangles a mean over the azimuth,
  /// closed without defocus. Error below 1e-13. Of polygons the overlap in one direction is exact
  /// (trapezoids), its mean over azimuth by Gauss-Legendre between the directions of the edges: error below
  /// 2e-5.
  double operator()(double x, double curvature = 0) const;
  /// Shear from which the OTF is 0 [m].
  double cutoff() const { return breakpoints_.back(); }
  /// Shears where it is not smooth, ascending, the last one the cutoff [m].
  const std::vector<double>& breakpoints() const { return breakpoints_; }
  /// Whether the aperture is a full circle, whose focal pattern has an encircled energy in closed form.
  bool is_circle() const { return inner_ == 0 && width_ == 0 && corners_.empty(); }

 private:
  double of_polygon(double x, double beta) const;

  double outer_ = 0, inner_ = 0;                // radii [m]
  double width_ = 0, height_ = 0;               // of a rectangle [m]
  std::vector<std::array<double, 2>> corners_;  // of a polygon [m]
  std::vector<double> edge_directions_;         // [rad]
  double area_ = 0;                             // of it [m^2]
  std::vector<double> breakpoints_;
};

}  // namespace aberfit
