#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "disc_polynomial.h"
#include "even_polynomial.h"

namespace aberfit::internal {

/// The wave in the pupil of a mirror without roughness, over the conjugate of the focal plane's coordinates:
/// P = f times the direction cosine of the ray that comes from there [m], P = r / (1 + t^2), t = r/2f
/// (PHYSICS 6). Even light on the aperture has the amplitude 2/((1 + c) sqrt(c)) there, c = sqrt(1 - (P/f)^2)
/// the cosine of the ray's angle.
class PupilField {
 public:
  using Point = std::array<double, 2>;
  /// Height of the surface above the parabola [m] at x, y [m].
  using Departure = std::function<double(double, double)>;

  /// `departure` is added to that of `mirror`; may be empty. Throws ComputationError where the mirror has no
  /// sag, or where it is 45 degrees steep, so that light does not come back to the focus.
  PupilField(const Mirror& mirror, const Aperture& aperture, double wavelength, const Departure& departure);

  double outer() const { return outer_; }    ///< largest |P| of the aperture [m]
  double inner() const { return inner_; }    ///< of an annulus [m]; 0 for all else
  double across() const { return across_; }  ///< longest shear that leaves an overlap [m]
  /// Of rectangles and polygons, P of points of the outline that a straight line follows within 2e-4 of the
  /// radius; empty for circle and annulus.
  const std::vector<Point>& corners() const { return corners_; }
  /// P of the aperture's own corners.
  const std::vector<Point>& straight_corners() const { return straight_corners_; }
  /// Directions of the aperture's straight edges in [0, pi), ascending.
  const std::vector<double>& edge_directions() const { return edge_directions_; }
  bool has_departure() const { return !is_parabola_; }
  /// Amplitude and phase depend on |P| alone.
  bool is_round() const { return is_round_; }
  bool is_rectangle() const { return is_rectangle_; }
  /// A polygon that is the same turned by half a turn: rectangles, hexagons.
  bool is_point_symmetric() const { return is_point_symmetric_; }
  double focal_length() const { return focal_length_; }
  double wavelength() const { return wavelength_; }

  /// Two points each, n pairs of them, in the plane f + dz: the product of their amplitudes, and the phase at
  /// the first less that at the second [rad], with the phase 4 pi h/(lambda (1 + t^2)) + (2 pi/lambda) dz
  /// (1 - c)/(1 + dz/f). scratch: room for n.
  void pairs(double dz, const double* x1, const double* y1, const double* x2, const double* y2, int n,
             double* amplitude, double* difference, double* scratch) const;

 private:
  double departure_at(double x, double y) const;
  double interpolated(double x, double y) const;
  void add_departure(const double* x, const double* y, int n, double* result) const;
  void tabulate();
  void outline(const Aperture& aperture);

  Departure departure_;  // of the mirror and what was added
  double focal_length_ = 0, wavelength_ = 0;
  double outer_ = 0, inner_ = 0, across_ = 0;
  bool is_parabola_ = true, is_round_ = true, is_rectangle_ = false, is_point_symmetric_ = false;
  std::vector<Point> corners_, straight_corners_;
  std::vector<double> edge_directions_;
  // Phase of the departure over P [rad], where it is round and its powers are few.
  std::optional<EvenPolynomial> even_;
  // Phase of the departure over x, y in P, where it is not round [rad]: a polynomial, or where none is near
  // enough a table.
  std::optional<DiscPolynomial> polynomial_;
  Eigen::ArrayXXd table_;
  double pitch_ = 0;  // of the table [m]
};

/// Largest distance of two of them, 0 of none.
double longest_distance(const std::vector<PupilField::Point>& points);
/// Directions of a polygon's edges in [0, pi), ascending, each once.
std::vector<double> edge_directions(const std::vector<PupilField::Point>& polygon);

}  // namespace aberfit::internal
