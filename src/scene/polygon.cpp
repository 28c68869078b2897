#include "polygon.h"

#include <algorithm>
#include <cmath>

namespace aberfit::internal {
namespace {

double distance_to_line(const std::array<double, 2>& p, const std::array<double, 2>& a,
                        const std::array<double, 2>& b) {
  const double ex = b[0] - a[0], ey = b[1] - a[1], length2 = ex * ex + ey * ey;
  double t = length2 > 0 ? ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / length2 : 0.0;
  t = std::clamp(t, 0.0, 1.0);
  return std::hypot(p[0] - a[0] - t * ex, p[1] - a[1] - t * ey);
}

}  // namespace

PolygonArea polygon_area(const Outline& vertices) {
  PolygonArea area;
  if (vertices.empty()) return area;
  double x = 0, y = 0;
  const auto& origin = vertices.front();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto &a = vertices[i], &b = vertices[(i + 1) % vertices.size()];
    const double ax = a[0] - origin[0], ay = a[1] - origin[1], bx = b[0] - origin[0], by = b[1] - origin[1];
    const double twice = ax * by - ay * bx;
    area.twice_area += twice;
    x += twice * (ax + bx);
    y += twice * (ay + by);
  }
  area.centroid = {origin[0] + x / (3 * area.twice_area), origin[1] + y / (3 * area.twice_area)};
  return area;
}

PolygonArea area_of(const std::vector<Outline>& outlines) {
  PolygonArea all;
  double x = 0, y = 0;
  for (const Outline& outline : outlines) {
    const PolygonArea one = polygon_area(outline);
    if (one.twice_area == 0) continue;
    all.twice_area += one.twice_area;
    x += one.twice_area * one.centroid[0];
    y += one.twice_area * one.centroid[1];
  }
  if (all.twice_area != 0) all.centroid = {x / all.twice_area, y / all.twice_area};
  return all;
}

double distance_to_outline(const Outline& outline, double x, double y) {
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < outline.size(); ++i)
    least = std::min(least, distance_to_line({x, y}, outline[i], outline[(i + 1) % outline.size()]));
  return least;
}

bool is_inside(std::span<const Outline> outlines, double x, double y, double margin) {
  int turns = 0;
  for (const Outline& v : outlines)
    for (std::size_t i = 0; i < v.size(); ++i) {
      const auto &a = v[i], &b = v[(i + 1) % v.size()];
      if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
        turns += b[1] > a[1] ? 1 : -1;
    }
  if (turns == 0 || margin <= 0) return turns != 0;
  return std::none_of(outlines.begin(), outlines.end(),
                      [&](const Outline& v) { return distance_to_outline(v, x, y) < margin; });
}

}  // namespace aberfit::internal
