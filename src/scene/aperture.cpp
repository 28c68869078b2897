#include "aberfit/scene/aperture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/overloaded.h"
#include "aberfit/core/quadrature.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

double cross(const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; }

double signed_area(const std::vector<Point>& v) {
  double twice = 0;
  for (std::size_t i = 0; i < v.size(); ++i) twice += cross(v[i], v[(i + 1) % v.size()]);
  return 0.5 * twice;
}

double distance_to_segment(const Point& p, const Point& a, const Point& b) {
  const double ex = b[0] - a[0], ey = b[1] - a[1], length2 = ex * ex + ey * ey;
  double t = length2 > 0 ? ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / length2 : 0.0;
  t = std::clamp(t, 0.0, 1.0);
  return std::hypot(p[0] - a[0] - t * ex, p[1] - a[1] - t * ey);
}

bool polygon_contains(const std::vector<Point>& v, double x, double y, double margin) {
  bool inside = false;
  for (std::size_t i = 0; i < v.size(); ++i) {  // even-odd rule
    const Point &a = v[i], &b = v[(i + 1) % v.size()];
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  if (!inside || margin <= 0) return inside;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (distance_to_segment({x, y}, v[i], v[(i + 1) % v.size()]) < margin) return false;
  return true;
}

// The right-angled triangle axis - foot of the perpendicular on an edge - one end of that edge. Seen from the
// axis, a circle of radius rho has the angle arctan(along/distance) - arccos(distance/rho) inside it once rho
// > distance.
struct HalfEdge {
  double distance;  // of the edge's line from the axis
  double along;     // from the foot to the end, >= 0
  double sign;      // of the area it adds

  double angle(double rho2) const {
    if (rho2 >= distance * distance + along * along) return 0.0;
    const double beyond2 = rho2 - distance * distance;
    const double whole = std::atan2(along, distance);
    return sign * (beyond2 > 0 ? whole - std::atan2(std::sqrt(beyond2), distance) : whole);
  }
};

std::vector<HalfEdge> half_edges(const std::vector<Point>& v) {
  std::vector<HalfEdge> result;
  const double sense = signed_area(v) < 0 ? -1.0 : 1.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Point &a = v[i], &b = v[(i + 1) % v.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (length == 0) continue;
    const Point unit{(b[0] - a[0]) / length, (b[1] - a[1]) / length};
    const double distance = cross(a, unit);
    if (distance == 0) continue;  // the edge points at the axis: no triangle
    const double side = distance < 0 ? -sense : sense;
    const double from = a[0] * unit[0] + a[1] * unit[1], to = b[0] * unit[0] + b[1] * unit[1];
    result.push_back({std::abs(distance), std::abs(to), to < 0 ? -side : side});
    result.push_back({std::abs(distance), std::abs(from), from < 0 ? side : -side});
  }
  return result;
}

// Density of rho^2 over a polygon is half the angle of the circle rho inside it. It has a square root's
// branch point where the circle touches an edge and a kink where it passes a corner. So: Gauss-Legendre
// between those radii, in the root of rho^2 from the branch point, on pieces not longer than a few times the
// distance to the next branch point below.
std::vector<RadialNode> polygon_nodes(const std::vector<Point>& vertices, int n) {
  const std::vector<HalfEdge> edges = half_edges(vertices);
  std::vector<double> breaks{0.0}, branches{0.0};
  double largest = 0;
  for (const HalfEdge& e : edges) {
    const double foot2 = e.distance * e.distance;
    breaks.push_back(foot2);
    branches.push_back(foot2);
    breaks.push_back(foot2 + e.along * e.along);
    largest = std::max(largest, breaks.back());
  }
  // Radii that rounding alone tells apart, e.g. of a regular polygon, are one.
  const auto merge = [&](std::vector<double>& list) {
    std::sort(list.begin(), list.end());
    const auto same = [&](double a, double b) { return b - a < 1e-13 * largest; };
    list.erase(std::unique(list.begin(), list.end(), same), list.end());
  };
  merge(breaks);
  merge(branches);

  const double area = std::abs(signed_area(vertices));
  const Quadrature unit = gauss_legendre(n, 0.0, 1.0);
  std::vector<RadialNode> nodes;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    for (double low = breaks[i]; low < breaks[i + 1];) {
      // Branch points below this piece; without any but the axis the angle is constant.
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
        if (angle < 1e-13) continue;  // the circle runs outside; rounding of the signed sum
        const double width = (high - low) * unit.weights[k] * (at_branch ? 2.0 * t : 1.0);
        nodes.push_back({std::sqrt(rho2), 0.5 * angle * width / area});
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

double largest_distance(const std::vector<Point>& v) {
  double radius = 0;
  for (const Point& p : v) radius = std::max(radius, std::hypot(p[0], p[1]));
  return radius;
}

}  // namespace

double aperture_radius(const Aperture& aperture) {
  return std::visit(Overloaded{[](const CircleAperture& a) { return 0.5 * a.diameter; },
                               [](const AnnulusAperture& a) { return 0.5 * a.diameter; },
                               [](const RectangleAperture& a) { return 0.5 * std::hypot(a.width, a.height); },
                               [](const PolygonAperture& a) { return largest_distance(a.vertices); }},
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
                               [](const PolygonAperture& a) { return std::abs(signed_area(a.vertices)); }},
                    aperture);
}

ApertureBox bounding_box(const Aperture& aperture) {
  const std::vector<Point> corners = aperture_corners(aperture);
  const double radius = aperture_radius(aperture);
  if (corners.empty()) return {-radius, radius, -radius, radius};
  ApertureBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const auto& [x, y] : corners)
    box = {std::min(box.x0, x), std::max(box.x1, x), std::min(box.y0, y), std::max(box.y1, y)};
  return box;
}

std::vector<Point> aperture_corners(const Aperture& aperture) {
  if (const auto* polygon = std::get_if<PolygonAperture>(&aperture)) return polygon->vertices;
  const auto* rectangle = std::get_if<RectangleAperture>(&aperture);
  if (!rectangle) return {};
  const double x = 0.5 * rectangle->width, y = 0.5 * rectangle->height;
  return {{x, -y}, {x, y}, {-x, y}, {-x, -y}};
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
                 [&](const PolygonAperture& a) { return polygon_contains(a.vertices, x, y, margin); }},
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
                               [&](const auto&) { return polygon_nodes(aperture_corners(aperture), n); }},
                    aperture);
}

}  // namespace aberfit
