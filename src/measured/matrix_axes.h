#pragma once
#include <cstddef>
#include <vector>

namespace aberfit::internal {

/// Fewest positions of an axis that is recognised as one.
inline constexpr std::size_t kLeastOnAxis = 4;

/// True where the first row and the first column of a matrix are positions, whatever stands in their common
/// corner: each has at least `kLeastOnAxis` numbers behind the corner, which ascend or descend in equal steps
/// to a twentieth. A tilted plane has such rows, too, but its second row and column go on in the same steps.
/// rows: the first rows of the matrix, of equal length.
bool has_axes(const std::vector<std::vector<double>>& rows);

}  // namespace aberfit::internal
