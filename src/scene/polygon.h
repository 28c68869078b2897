#pragma once
#include <array>
#include <span>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// Signed area (positive where the corners go round counter-clockwise) and centroid of a polygon, about its
/// first corner, so that one far off loses no digits. None without corners.
struct PolygonArea {
  double twice_area = 0;                 ///< [m^2]
  std::array<double, 2> centroid{0, 0};  ///< [m]
};
PolygonArea polygon_area(const Outline& vertices);
/// The sum over outlines, each of which counts with its sense; nothing, about the axis, without any.
PolygonArea area_of(const std::vector<Outline>& outlines);

/// The distance of a point from the nearest edge [m], whichever side it is on.
double distance_to_outline(const Outline& outline, double x, double y);
/// Whether the outlines go round (x, y), and all edges are at least `margin` [m] away.
bool is_inside(std::span<const Outline> outlines, double x, double y, double margin);

}  // namespace aberfit::internal
