#pragma once
#include <array>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// Signed area (positive where the corners go round counter-clockwise) and centroid of a polygon, about its
/// first corner, so that one far off loses no digits.
struct PolygonArea {
  double twice_area = 0;                 ///< [m^2]
  std::array<double, 2> centroid{0, 0};  ///< [m]
};
PolygonArea polygon_area(const Outline& vertices);
/// Of outlines that each count with their sense; about the axis where there are none.
PolygonArea area_of(const std::vector<Outline>& outlines);

}  // namespace aberfit::internal
