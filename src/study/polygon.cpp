#include "polygon.h"

#include <fmt/format.h>

#include <algorithm>

namespace aberfit::internal {
namespace {

using Point = std::array<double, 2>;

// Twice the signed area of a, b, c.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

bool within_box(const Point& a, const Point& b, const Point& p) {
  return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) && std::min(a[1], b[1]) <= p[1] &&
         p[1] <= std::max(a[1], b[1]);
}

// Returns whether the closed segments ab and cd share a point.
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (((abc > 0) != (abd > 0)) && abc != 0 && abd != 0 && ((cda > 0) != (cdb > 0)) && cda != 0 && cdb != 0)
    return true;
  return (abc == 0 && within_box(a, b, c)) || (abd == 0 && within_box(a, b, d)) ||
         (cda == 0 && within_box(c, d, a)) || (cdb == 0 && within_box(c, d, b));
}

}  // namespace

std::string polygon_problem(const std::vector<std::array<double, 2>>& vertices) {
  const std::size_t n = vertices.size();
  double area = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point &a = vertices[i], &b = vertices[(i + 1) % n], &c = vertices[(i + 2) % n];
    if (a == b) return fmt::format("corners {} and {} at the same place", i, (i + 1) % n);
    area += a[0] * b[1] - a[1] * b[0];
    // Neighbouring edges share a corner; they overlap where the path turns straight back.
    const double backwards = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
    if (turn(a, b, c) == 0 && backwards < 0)
      return fmt::format("edges that fold back at corner {}", (i + 1) % n);
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (meet(a, b, vertices[j], vertices[(j + 1) % n]))
        return fmt::format("edges {} and {} that meet", i, j);
    }
  }
  return area == 0 ? "no area" : "";
}

bool overlap(const std::vector<Outline>& outlines) {
  constexpr double kTouching = 1e-9;  // fraction of the other outline's radius
  for (const Outline& one : outlines)
    for (const Outline& other : outlines) {
      if (&one == &other) continue;
      const PolygonAperture inside{other, 0};
      const double margin = kTouching * aperture_radius(inside);
      for (std::size_t i = 0; i < one.size(); ++i) {
        const auto &a = one[i], &b = one[(i + 1) % one.size()];
        if (aperture_contains(inside, a[0], a[1], margin) ||
            aperture_contains(inside, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), margin))
          return true;
      }
    }
  return false;
}

}  // namespace aberfit::internal
