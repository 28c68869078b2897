#pragma once
#include <array>
#include <string>
#include <vector>

namespace aberfit::internal {

/// What is wrong with a polygon aperture, in words: corners that repeat, edges that cross or touch, no area.
/// Empty when it is simple. vertices: at least 3, [m]. O(n^2).
std::string polygon_problem(const std::vector<std::array<double, 2>>& vertices);

}  // namespace aberfit::internal
