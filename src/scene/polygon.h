#pragma once
#include <array>
#include <span>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// Signed area (positive for counter-clockwise corners) and centroid of a polygon; both are zero without
/// corners. They are computed about the first corner, so a distant polygon loses no digits.
struct PolygonArea {
  double twice_area = 0;                 ///< [m^2]
  std::array<double, 2> centroid{0, 0};  ///< [m]
};
PolygonArea polygon_area(const Outline& vertices);
/// The sum over signed outlines; zero area and centroid without outlines.
PolygonArea area_of(const std::vector<Outline>& outlines);

/// Distance of a point from the nearest edge [m], on either side of it.
double distance_to_outline(const Outline& outline, double x, double y);
/// Returns whether the outlines enclose (x, y) and every edge is at least `margin` [m] away.
bool is_inside(std::span<const Outline> outlines, double x, double y, double margin);

}  // namespace aberfit::internal
