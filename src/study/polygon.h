#pragma once
#include <array>
#include <string>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit::internal {

/// What is wrong with a polygon aperture, in words: corners that repeat, edges that cross or touch, no area.
/// Empty when it is simple. vertices: at least 3, [m]. O(n^2).
std::string polygon_problem(const std::vector<std::array<double, 2>>& vertices);

/// Whether a corner or the middle of an edge of one outline lies inside another, edges not included.
bool overlap(const std::vector<Outline>& outlines);

}  // namespace aberfit::internal
