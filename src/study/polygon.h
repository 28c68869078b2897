#pragma once
#include <array>
#include <string>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// Says what is wrong with a polygon aperture: repeated corners, edges that cross or touch, or no area. Empty
/// if the polygon is simple. vertices: at least 3, [m]. O(n^2).
std::string polygon_problem(const std::vector<std::array<double, 2>>& vertices);

/// Returns whether a corner or the midpoint of an edge of one outline lies inside another; edges do not count
/// as inside.
bool overlap(const std::vector<Outline>& outlines);

}  // namespace aberfit::internal
