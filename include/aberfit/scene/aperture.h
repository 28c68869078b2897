#pragma once
#include <Eigen/Core>
#include <array>
#include <variant>
#include <vector>

namespace aberfit {

/// Clear apertures in the x-y plane. They are centred on the axis, except polygons. Lengths [m]. `margin` is
/// the width along every edge that random, Sobol and grid points avoid (the edge margin of the paper).
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
  std::vector<std::array<double, 2>> vertices;  ///< corners of a simple polygon, in either sense
  double margin = 0;
  bool operator==(const PolygonAperture&) const = default;
};
/// Corners of a closed line, in order.
using Outline = std::vector<std::array<double, 2>>;
/// A segmented or obstructed aperture, described by signed outlines. A point is clear where its winding
/// number is 1, or -1 if the total signed area is negative. Outlines of the opposite sense are holes.
struct SegmentedAperture {
  std::vector<Outline> outlines;
  double margin = 0;
  /// Each segment, i.e. each outline around a clear area, has its own piston, tip and tilt. They are
  /// independent normal variables with these standard deviations.
  double piston = 0;    ///< standard deviation of the height of a segment [m]
  double tip_tilt = 0;  ///< standard deviation of each of the two slopes of a segment
  bool operator==(const SegmentedAperture&) const = default;
};
using Aperture =
    std::variant<CircleAperture, AnnulusAperture, RectangleAperture, PolygonAperture, SegmentedAperture>;

/// A vane of a support in front of the mirror: a strip that runs outwards from the axis.
struct Vane {
  double width = 0;   ///< [m], > 0
  double angle = 0;   ///< direction of the vane, from x towards y [rad]
  double offset = 0;  ///< shift of its centre line from the axis, to the left [m]
  bool operator==(const Vane&) const = default;
};
/// The aperture without the area of the vanes. A circle becomes a 1,440-gon, whose area is 3e-6 smaller. A
/// study file cannot name these outlines: a program that fills a Study names shape and vanes in
/// Study::obstructed.
SegmentedAperture obstructed(const Aperture& aperture, const std::vector<Vane>& vanes);
/// Outlines of a transmission mask. `share` is the transmitted fraction of each pixel, 0 to 1 (NaN counts as
/// 0). Rows run along y and columns along x; the centre of the mask lies on the axis. `pitch`: pixel width
/// [m]. The edge is where linear interpolation between two pixels gives one half, so it is located to a
/// fraction of a pixel. Throws ComputationError when nothing is clear, or when the area of the outlines and
/// the sum of the mask differ by more than 1 %.
SegmentedAperture mask_outlines(const Eigen::ArrayXXd& share, double pitch);
/// Hexagonal segments in rings about the axis. `flat_to_flat` is the width of a segment [m], `gap` the
/// distance between facing edges [m]. `centre` keeps the segment on the axis. Corners point along x for
/// `angle` [rad] = 0.
SegmentedAperture hexagonal_segments(int rings, double flat_to_flat, double gap, bool centre, double angle);

/// Radius of the smallest circle about the axis that holds the aperture [m]: R of every formula.
double aperture_radius(const Aperture& aperture);
/// Clear area [m^2]; the margin is not subtracted.
double aperture_area(const Aperture& aperture);
/// The smallest rectangle along x and y that holds the aperture [m].
struct ApertureBox {
  double x0, x1, y0, y1;
};
ApertureBox bounding_box(const Aperture& aperture);
/// Outlines of a shape with corners. A rectangle or a polygon has one; a circle or an annulus has none.
std::vector<Outline> aperture_outlines(const Aperture& aperture);
/// The same outlines, each counter-clockwise.
std::vector<Outline> counter_clockwise(std::vector<Outline> outlines);
/// Returns whether (x, y) is inside and at least `margin` away from every edge.
bool aperture_contains(const Aperture& aperture, double x, double y, double margin);
/// Returns whether a sample at (x, y) belongs to the mirror. Rounding would decide for a sample on the rim,
/// so the test scales x and y by 1 - 1e-9.
bool aperture_holds(const Aperture& aperture, double x, double y);
double aperture_margin(const Aperture& aperture);

/// One node of the distribution of rho over the aperture.
struct RadialNode {
  double rho;     ///< distance from the axis [m]
  double weight;  ///< fraction of the area, >= 0; sums to 1
};
/// Quadrature over the aperture of functions of rho: mean of g(rho) = sum weight g(rho), for g smooth in
/// rho^2. The margin is not subtracted.
/// Circle and annulus: n-point Gauss-Legendre in rho^2, exact for polynomials in rho^2 up to degree 2n - 1.
/// Other shapes: the density of rho^2 / 2 is the angle of the circle of radius rho inside the aperture, in
/// closed form. Each interval between radii where the circle touches an edge or passes a corner has n points
/// (3 n in all for a rectangle). The error is 1e-13 for n = 16.
std::vector<RadialNode> radial_quadrature(const Aperture& aperture, int n);

}  // namespace aberfit
