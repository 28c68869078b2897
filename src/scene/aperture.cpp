#include "aberfit/scene/aperture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/overloaded.h"
#include "aberfit/core/quadrature.h"
#include "polygon.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

double cross(const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; }

double signed_area(const std::vector<Outline>& outlines) {
  return 0.5 * internal::area_of(outlines).twice_area;
}

// A right-angled triangle: the axis, the foot of the perpendicular on an edge's line, and one end of that
// edge. For rho > distance, a circle of radius rho about the axis has the angle arctan(along/distance) -
// arccos(distance/rho) inside it.
struct HalfEdge {
  double distance;  // from the axis to the edge's line
  double along;     // from the foot to the end, >= 0
  double sign;      // sign of its area
  double whole = std::atan2(along, distance);

  double angle(double rho2) const {
    if (rho2 >= distance * distance + along * along) return 0.0;
    const double beyond2 = rho2 - distance * distance;
    return sign * (beyond2 > 0 ? whole - std::atan2(std::sqrt(beyond2), distance) : whole);
  }
};

void add_half_edges(const Outline& v, double sense, std::vector<HalfEdge>* result) {
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Point &a = v[i], &b = v[(i + 1) % v.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (length == 0) continue;
    const Point unit{(b[0] - a[0]) / length, (b[1] - a[1]) / length};
    const double distance = cross(a, unit);
    if (distance == 0) continue;  // the edge points at the axis and forms no triangle
    const double side = distance < 0 ? -sense : sense;
    const double from = a[0] * unit[0] + a[1] * unit[1], to = b[0] * unit[0] + b[1] * unit[1];
    result->push_back({std::abs(distance), std::abs(to), to < 0 ? -side : side});
    result->push_back({std::abs(distance), std::abs(from), from < 0 ? side : -side});
  }
}

// The density of rho^2 over a polygon is half the angle of the circle of radius rho inside it. It has a
// square-root branch point where the circle touches an edge and a kink where the circle passes a corner. So
// we use Gauss-Legendre between those radii, in the root of rho^2 measured from the branch point. A piece is
// at most a few times as long as the distance to the next branch point below.
std::vector<RadialNode> nodes_inside(const std::vector<Outline>& outlines, int n) {
  const double area = signed_area(outlines);
  std::vector<HalfEdge> edges;
  for (const Outline& outline : outlines) add_half_edges(outline, area < 0 ? -1.0 : 1.0, &edges);
  std::vector<double> breaks{0.0}, branches{0.0};
  double largest = 0;
  for (const HalfEdge& e : edges) {
    const double foot2 = e.distance * e.distance;
    breaks.push_back(foot2);
    branches.push_back(foot2);
    breaks.push_back(foot2 + e.along * e.along);
    largest = std::max(largest, breaks.back());
  }
  // Radii that differ only by rounding, e.g. those of a regular polygon, are merged. So are the feet and
  // corners of the chords of a circle.
  constexpr std::size_t kMany = 600;
  const double apart = edges.size() > kMany ? 1e-5 : 1e-13;
  const auto merge = [&](std::vector<double>& list) {
    std::sort(list.begin(), list.end());
    const auto same = [&](double a, double b) { return b - a < apart * largest; };
    list.erase(std::unique(list.begin(), list.end(), same), list.end());
  };
  merge(breaks);
  merge(branches);
  if (breaks.back() < largest) breaks.push_back(largest);

  const Quadrature unit = gauss_legendre(n, 0.0, 1.0);
  std::vector<RadialNode> nodes;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    for (double low = breaks[i]; low < breaks[i + 1];) {
      // Branch points below this piece. If the axis is the only one, the angle is constant.
      auto above = std::upper_bound(branches.begin(), branches.end(), low + 1e-13 * largest);
      const bool at_branch = above - 1 != branches.begin() && std::abs(*(above - 1) - low) < 1e-13 * largest;
      const auto nearest = at_branch ? above - 2 : above - 1;
      const bool constant = !at_branch && nearest == branches.begin();
      double high = breaks[i + 1];
      if (!constant && low + 5.0 * (low - *nearest) < high) high = low + 3.0 * (low - *nearest);
      for (int k = 0; k < n; ++k) {
        const double t = unit.nodes[k];
        const double rho2 = low + (high - low) * (at_branch ? t * t : t);
        double angle = 0;
        for (const HalfEdge& e : edges) angle += e.angle(rho2);
        if (angle < 1e-13) continue;  // the circle lies outside; the signed sum is rounding error
        const double width = (high - low) * unit.weights[k] * (at_branch ? 2.0 * t : 1.0);
        nodes.push_back({std::sqrt(rho2), 0.5 * angle * width / std::abs(area)});
      }
      low = high;
    }
  }
  return nodes;
}

std::vector<RadialNode> ring_nodes(double inner, double outer, int n) {
  const Quadrature rule = gauss_legendre(n, inner * inner, outer * outer);
  std::vector<RadialNode> nodes;
  for (int k = 0; k < n; ++k)
    nodes.push_back({std::sqrt(rule.nodes[k]), rule.weights[k] / (outer * outer - inner * inner)});
  return nodes;
}

double largest_distance(const std::vector<Outline>& outlines) {
  double radius = 0;
  for (const Outline& outline : outlines)
    for (const Point& p : outline) radius = std::max(radius, std::hypot(p[0], p[1]));
  return radius;
}

constexpr int kChords = 1440;

Outline circle_outline(double diameter) {
  Outline outline;
  for (int k = 0; k < kChords; ++k) {
    const double angle = 2 * std::numbers::pi * k / kChords;
    outline.push_back({0.5 * diameter * std::cos(angle), 0.5 * diameter * std::sin(angle)});
  }
  return outline;
}

// All outlines of any shape, counter-clockwise around clear areas.
std::vector<Outline> straightened(const Aperture& aperture) {
  if (const auto* circle = std::get_if<CircleAperture>(&aperture)) return {circle_outline(circle->diameter)};
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture)) {
    std::vector<Outline> both{circle_outline(annulus->diameter), circle_outline(annulus->inner_diameter)};
    std::reverse(both[1].begin(), both[1].end());
    return both;
  }
  std::vector<Outline> outlines = aperture_outlines(aperture);
  if (signed_area(outlines) < 0)
    for (Outline& outline : outlines) std::reverse(outline.begin(), outline.end());
  return outlines;
}

// The part of an outline with normal . p <= limit (Sutherland and Hodgman 1974).
Outline clipped(const Outline& outline, const Point& normal, double limit) {
  Outline result;
  const auto beyond = [&](const Point& p) { return normal[0] * p[0] + normal[1] * p[1] - limit; };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const double at_a = beyond(a), at_b = beyond(b);
    if (at_a <= 0) result.push_back(a);
    if ((at_a <= 0) == (at_b <= 0)) continue;
    const double part = at_a / (at_a - at_b);
    result.push_back({a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])});
  }
  return result;
}

}  // namespace

double aperture_radius(const Aperture& aperture) {
  return std::visit(Overloaded{[](const CircleAperture& a) { return 0.5 * a.diameter; },
                               [](const AnnulusAperture& a) { return 0.5 * a.diameter; },
                               [](const RectangleAperture& a) { return 0.5 * std::hypot(a.width, a.height); },
                               [](const PolygonAperture& a) { return largest_distance({a.vertices}); },
                               [](const SegmentedAperture& a) { return largest_distance(a.outlines); }},
                    aperture);
}

double aperture_area(const Aperture& aperture) {
  constexpr double quarter_pi = 0.25 * std::numbers::pi;
  return std::visit(Overloaded{[](const CircleAperture& a) { return quarter_pi * a.diameter * a.diameter; },
                               [](const AnnulusAperture& a) {
                                 return quarter_pi * (a.diameter - a.inner_diameter) *
                                        (a.diameter + a.inner_diameter);
                               },
                               [](const RectangleAperture& a) { return a.width * a.height; },
                               [](const PolygonAperture& a) { return std::abs(signed_area({a.vertices})); },
                               [](const SegmentedAperture& a) { return std::abs(signed_area(a.outlines)); }},
                    aperture);
}

ApertureBox bounding_box(const Aperture& aperture) {
  const std::vector<Outline> outlines = aperture_outlines(aperture);
  const double radius = aperture_radius(aperture);
  if (outlines.empty()) return {-radius, radius, -radius, radius};
  ApertureBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const Outline& outline : outlines)
    for (const auto& [x, y] : outline)
      box = {std::min(box.x0, x), std::max(box.x1, x), std::min(box.y0, y), std::max(box.y1, y)};
  return box;
}

std::vector<Outline> aperture_outlines(const Aperture& aperture) {
  if (const auto* polygon = std::get_if<PolygonAperture>(&aperture)) return {polygon->vertices};
  if (const auto* segmented = std::get_if<SegmentedAperture>(&aperture)) return segmented->outlines;
  const auto* rectangle = std::get_if<RectangleAperture>(&aperture);
  if (!rectangle) return {};
  const double x = 0.5 * rectangle->width, y = 0.5 * rectangle->height;
  return {{{x, -y}, {x, y}, {-x, y}, {-x, -y}}};
}

// Each covered part is added with its sense reversed. Parts of holes and of earlier vanes are reversed too,
// so nothing is subtracted twice.
SegmentedAperture obstructed(const Aperture& aperture, const std::vector<Vane>& vanes) {
  SegmentedAperture result;
  if (const auto* segmented = std::get_if<SegmentedAperture>(&aperture)) result = *segmented;
  result.outlines = straightened(aperture);
  result.margin = aperture_margin(aperture);
  for (const Vane& vane : vanes) {
    const double c = std::cos(vane.angle), s = std::sin(vane.angle), half = 0.5 * vane.width;
    std::vector<Outline> covered;
    for (const Outline& outline : result.outlines) {
      Outline part = clipped(outline, {-c, -s}, 0);
      part = clipped(part, {-s, c}, vane.offset + half);
      part = clipped(part, {s, -c}, half - vane.offset);
      std::reverse(part.begin(), part.end());
      if (part.size() > 2) covered.push_back(std::move(part));
    }
    result.outlines.insert(result.outlines.end(), covered.begin(), covered.end());
  }
  return result;
}

SegmentedAperture hexagonal_segments(int rings, double flat_to_flat, double gap, bool centre, double angle) {
  SegmentedAperture result;
  const double pitch = flat_to_flat + gap, corner = flat_to_flat / std::numbers::sqrt3;
  for (int q = -rings; q <= rings; ++q)
    for (int r = std::max(-rings, -q - rings); r <= std::min(rings, rings - q); ++r) {
      if (q == 0 && r == 0 && !centre) continue;
      const double x = 0.5 * std::numbers::sqrt3 * pitch * q, y = pitch * (r + 0.5 * q);
      Outline& outline = result.outlines.emplace_back();
      for (int k = 0; k < 6; ++k) {
        const double turn = angle + k * std::numbers::pi / 3;
        outline.push_back({x * std::cos(angle) - y * std::sin(angle) + corner * std::cos(turn),
                           x * std::sin(angle) + y * std::cos(angle) + corner * std::sin(turn)});
      }
    }
  return result;
}

std::vector<Outline> counter_clockwise(std::vector<Outline> outlines) {
  for (Outline& outline : outlines)
    if (internal::polygon_area(outline).twice_area < 0) std::reverse(outline.begin(), outline.end());
  return outlines;
}

bool aperture_contains(const Aperture& aperture, double x, double y, double margin) {
  return std::visit(
      Overloaded{[&](const CircleAperture& a) { return std::hypot(x, y) <= 0.5 * a.diameter - margin; },
                 [&](const AnnulusAperture& a) {
                   const double rho = std::hypot(x, y);
                   const double inner = a.inner_diameter > 0 ? 0.5 * a.inner_diameter + margin : 0.0;
                   return rho <= 0.5 * a.diameter - margin && rho >= inner;
                 },
                 [&](const RectangleAperture& a) {
                   return std::abs(x) <= 0.5 * a.width - margin && std::abs(y) <= 0.5 * a.height - margin;
                 },
                 [&](const PolygonAperture& a) {
                   return internal::is_inside({&a.vertices, 1}, x, y, margin);
                 },
                 [&](const SegmentedAperture& a) { return internal::is_inside(a.outlines, x, y, margin); }},
      aperture);
}

bool aperture_holds(const Aperture& aperture, double x, double y) {
  constexpr double kOnTheRim = 1 - 1e-9;
  return aperture_contains(aperture, x * kOnTheRim, y * kOnTheRim, 0);
}

double aperture_margin(const Aperture& aperture) {
  return std::visit([](const auto& a) { return a.margin; }, aperture);
}

std::vector<RadialNode> radial_quadrature(const Aperture& aperture, int n) {
  return std::visit(Overloaded{[&](const CircleAperture& a) { return ring_nodes(0.0, 0.5 * a.diameter, n); },
                               [&](const AnnulusAperture& a) {
                                 return ring_nodes(0.5 * a.inner_diameter, 0.5 * a.diameter, n);
                               },
                               [&](const auto&) { return nodes_inside(aperture_outlines(aperture), n); }},
                    aperture);
}

}  // namespace aberfit
