#pragma once
#include <utility>
#include <vector>

#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// What the convex hull of the valid points covers of each row: first and last column, whole or broken; of a
/// row that it does not reach, an interval without points (first > last).
std::vector<std::pair<double, double>> convex_rows(const HeightMap& map);

}  // namespace aberfit::internal
