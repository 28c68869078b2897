#include "aberfit/measured/height_map.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "aberfit/core/random.h"
#include "convex_rows.h"

namespace aberfit {
namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

// Corners of the convex hull of the valid points in (column, row); only ends of rows can be corners.
std::vector<Point> hull_corners(const HeightMap& map) {
  std::vector<Point> ends;  // ascending in row, then in column
  for (Eigen::Index row = 0; row < map.rows(); ++row) {
    Eigen::Index first = 0, last = map.columns() - 1;
    while (first <= last && !std::isfinite(map.height(row, first))) ++first;
    while (last > first && !std::isfinite(map.height(row, last))) --last;
    if (first > last) continue;
    ends.push_back(Point(double(first), double(row)));
    if (last > first) ends.push_back(Point(double(last), double(row)));
  }
  if (ends.size() < 3) return ends;
  // Monotone chain (Andrew 1979). Products of integers are exact.
  std::vector<Point> corners;
  const auto chain = [&corners](const auto begin, const auto end) {
    const std::size_t start = corners.size();
    for (auto point = begin; point != end; ++point) {
      while (corners.size() >= start + 2 &&
             cross(corners.back() - corners[corners.size() - 2], *point - corners.back()) <= 0)
        corners.pop_back();
      corners.push_back(*point);
    }
    corners.pop_back();  // it starts the other chain
  };
  chain(ends.begin(), ends.end());
  chain(ends.rbegin(), ends.rend());
  return corners;
}

bool holds(const Circle& circle, const Point& point) {
  constexpr double kRounding = 1e-12;
  return std::hypot(point.x() - circle.x, point.y() - circle.y) <= circle.radius * (1 + kRounding);
}

Circle circle_of(const Point& a, const Point& b) {
  const Point middle = (a + b) / 2;
  return {middle.x(), middle.y(), (b - a).norm() / 2};
}

// Circumscribed circle; for three points on a line the circle of the widest pair.
Circle circle_of(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - a;
  const double twice_area = cross(u, v);
  if (twice_area == 0) {
    const Circle pairs[] = {circle_of(a, b), circle_of(a, c), circle_of(b, c)};
    return *std::max_element(std::begin(pairs), std::end(pairs),
                             [](const Circle& p, const Circle& q) { return p.radius < q.radius; });
  }
  const Point centre = Point(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                             u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                       (2 * twice_area);
  return {a.x() + centre.x(), a.y() + centre.y(), centre.norm()};
}

}  // namespace

Eigen::Index valid_count(const HeightMap& map) { return map.height.isFinite().count(); }

void centre_on_grid(HeightMap* map) {
  map->x0 = -map->pitch_x * double(std::max<Eigen::Index>(map->columns() - 1, 0)) / 2;
  map->y0 = -map->pitch_y * double(std::max<Eigen::Index>(map->rows() - 1, 0)) / 2;
}

Circle enclosing_circle(const HeightMap& map) {
  std::vector<Point> points = hull_corners(map);
  if (points.empty()) return {map.x0, map.y0, 0};
  for (Point& point : points) point = Point(point.x() * map.pitch_x, point.y() * map.pitch_y);
  // Incremental construction (Welzl 1991), linear on average for a random order; the order is reproducible.
  const RandomStream stream(1, "enclosing_circle");
  for (std::size_t i = points.size() - 1; i > 0; --i)
    std::swap(points[i], points[std::size_t(stream.bits(i) % (i + 1))]);
  Circle circle{points[0].x(), points[0].y(), 0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (holds(circle, points[i])) continue;
    circle = {points[i].x(), points[i].y(), 0};
    for (std::size_t j = 0; j < i; ++j) {
      if (holds(circle, points[j])) continue;
      circle = circle_of(points[i], points[j]);
      for (std::size_t k = 0; k < j; ++k)
        if (!holds(circle, points[k])) circle = circle_of(points[i], points[j], points[k]);
    }
  }
  // Rounding may leave points outside, so the radius is enlarged to hold them all.
  for (const Point& point : points)
    circle.radius = std::max(circle.radius, std::hypot(point.x() - circle.x, point.y() - circle.y));
  circle.x += map.x0;
  circle.y += map.y0;
  return circle;
}

std::vector<std::pair<double, double>> internal::convex_rows(const HeightMap& map) {
  std::vector<std::pair<double, double>> rows(std::size_t(map.rows()), {1, 0});
  const std::vector<Point> corners = hull_corners(map);
  const auto widen = [&](Eigen::Index row, double column) {
    auto& [first, last] = rows[std::size_t(row)];
    if (first > last) first = last = column;
    first = std::min(first, column), last = std::max(last, column);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Point low = corners[i], high = corners[(i + 1) % corners.size()];
    if (low.y() > high.y()) std::swap(low, high);
    widen(Eigen::Index(low.y()), low.x());
    widen(Eigen::Index(high.y()), high.x());
    for (auto row = Eigen::Index(low.y()) + 1; row < Eigen::Index(high.y()); ++row)
      widen(row, low.x() + (double(row) - low.y()) / (high.y() - low.y()) * (high.x() - low.x()));
  }
  return rows;
}

void move_origin(HeightMap* map, double x, double y) {
  map->x0 -= x;
  map->y0 -= y;
}

}  // namespace aberfit
