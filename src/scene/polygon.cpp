#include "polygon.h"

namespace aberfit::internal {

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

}  // namespace aberfit::internal
