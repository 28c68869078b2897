#pragma once
#include <Eigen/Core>
#include <array>
#include <variant>
#include <vector>

namespace aberfit {

/// Clear apertures in the x-y plane, centred on the axis unless the polygon says otherwise. Lengths [m].
/// `margin`: width along every edge that random, Sobol and grid points keep clear of (the paper's edge
/// margin).
struct CircleAperture {
  double diameter = 0;
  double margin = 0;
  bool operator==(const CircleAperture&) const = default;
};
struct AnnulusAperture {
  double diameter = 0;
  double inner_diameter = 0;
  double margin = 0;
  bool operator==(const AnnulusAperture&) const = default;
};
struct RectangleAperture {
  double width = 0;   ///< along x
  double height = 0;  ///< along y
  double margin = 0;
  bool operator==(const RectangleAperture&) const = default;
};
struct PolygonAperture {
  std::vector<std::array<double, 2>> vertices;  ///< corners in order, either sense, simple polygon
  double margin = 0;
  bool operator==(const PolygonAperture&) const = default;
};
/// Corners of a closed line, in order.
using Outline = std::vector<std::array<double, 2>>;
/// Segments, or what obstructions leave of an aperture: clear where the outlines, each with its sense, go
/// round once (winding number 1, or -1 where they enclose a negative area in all). Outlines that go round the
/// other way are holes.
struct SegmentedAperture {
  std::vector<Outline> outlines;
  double margin = 0;
  /// Each segment, an outline that goes round what is clear, stands off by its own piston, tip and tilt:
  /// independent normal draws with these standard deviations.
  double piston = 0;    ///< of the height of a segment [m]
  double tip_tilt = 0;  ///< of its slope along x, and of that along y
  bool operator==(const SegmentedAperture&) const = default;
};
using Aperture =
    std::variant<CircleAperture, AnnulusAperture, RectangleAperture, PolygonAperture, SegmentedAperture>;

/// A vane that holds what stands before a mirror: a strip from the axis outwards.
struct Vane {
  double width = 0;   ///< [m], > 0
  double angle = 0;   ///< of its direction, from x to y [rad]
  double offset = 0;  ///< of its middle line from the axis, to the left [m]
  bool operator==(const Vane&) const = default;
};
/// The aperture less what the vanes cover. Circles are taken by 1,440 chords, which is 3e-6 of their area
/// less.
SegmentedAperture obstructed(const Aperture& aperture, const std::vector<Vane>& vanes);
/// The outlines of a mask: where its share, 0 to 1 (NaN: 0) in pixels of `pitch` [m], is one half between two
/// pixels, so that an edge keeps its place to a part of a pixel. Rows along y, columns along x, the middle on
/// the axis. Throws ComputationError where nothing is clear, or more than edges are grey.
SegmentedAperture mask_outlines(const Eigen::ArrayXXd& share, double pitch);
/// Hexagons in rings about the axis, with corners on the x axis where `angle` [rad] is 0: segments of
/// `flat_to_flat` [m] with gaps of `gap` [m] between their edges, with or without the one on the axis.
SegmentedAperture hexagonal_segments(int rings, double flat_to_flat, double gap, bool centre, double angle);

/// Radius of the smallest circle about the axis that holds the aperture [m]: R of the Zernike terms and of
/// every formula.
double aperture_radius(const Aperture& aperture);
/// Clear area [m^2], margin not taken off.
double aperture_area(const Aperture& aperture);
/// The smallest upright rectangle that holds the aperture [m].
struct ApertureBox {
  double x0, x1, y0, y1;
};
ApertureBox bounding_box(const Aperture& aperture);
/// The outlines of a shape with corners: one of a rectangle or a polygon, none of what is round.
std::vector<Outline> aperture_outlines(const Aperture& aperture);
/// The same outlines, each counter-clockwise.
std::vector<Outline> counter_clockwise(std::vector<Outline> outlines);
/// Whether (x, y) is inside and at least `margin` away from every edge.
bool aperture_contains(const Aperture& aperture, double x, double y, double margin);
/// Whether a sample at (x, y) is of the mirror. One on a rim, where rounding would decide, is taken 1e-9 of
/// its distance nearer to the vertex.
bool aperture_holds(const Aperture& aperture, double x, double y);
double aperture_margin(const Aperture& aperture);

/// One node of the distribution of rho over the aperture.
struct RadialNode {
  double rho;     ///< distance from the axis [m]
  double weight;  ///< share of the area, >= 0; sums to 1
};
/// Quadrature of functions of rho over the aperture: mean of g(rho) = sum weight g(rho), spectrally accurate
/// for g smooth in rho^2. Circle and annulus: n-point Gauss-Legendre in rho^2, exact for polynomials in rho^2
/// up to degree 2n - 1. All else: the angle of the circle of radius rho inside the aperture
/// (closed form) is the density of rho^2 / 2; n points on every piece between the radii where it touches an
/// edge or passes a corner (3 n points for a rectangle). Measured with n = 16: 1e-13. Margin not taken off.
std::vector<RadialNode> radial_quadrature(const Aperture& aperture, int n);

}  // namespace aberfit
