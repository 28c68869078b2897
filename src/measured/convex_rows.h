#pragma once
#include <utility>
#include <vector>

#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// For each row, returns the columns that the convex hull of the valid points covers: first and last,
/// possibly fractional. A row outside the hull gives an empty interval (first > last).
std::vector<std::pair<double, double>> convex_rows(const HeightMap& map);

}  // namespace aberfit::internal
