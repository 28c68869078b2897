#pragma once
#include <cstddef>
#include <vector>

namespace aberfit::internal {

/// Smallest number of positions that are recognised as an axis.
inline constexpr std::size_t kLeastOnAxis = 4;

/// Returns true if the first row and column of a matrix are positions, whatever their common corner holds.
/// Each needs `kLeastOnAxis` numbers after the corner in equal steps to 1/20. The second row and column must
/// not continue in the same steps, as those of a tilted plane do. rows: the first rows, of equal length.
bool has_axes(const std::vector<std::vector<double>>& rows);

}  // namespace aberfit::internal
