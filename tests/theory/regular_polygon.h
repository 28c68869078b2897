#pragma once
#include <cmath>
#include <numbers>

#include "aberfit/scene/aperture.h"

namespace aberfit::test {

/// Corners at `radius` [m] from the axis, the first in this direction [rad], counter-clockwise.
inline PolygonAperture regular_polygon(int corners, double radius, double direction) {
  PolygonAperture aperture;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners + direction;
    aperture.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return aperture;
}

}  // namespace aberfit::test
