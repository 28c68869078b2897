#include "polygon.h"

namespace aberfit::internal {

PolygonArea polygon_area(const std::vector<std::array<double, 2>>& vertices) {
  PolygonArea area;
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

}  // namespace aberfit::internal
