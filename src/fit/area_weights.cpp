#include "area_weights.h"

#include <algorithm>
#include <cstdlib>

namespace aberfit::internal {
namespace {

using Eigen::Index;
using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr Index kReach = 2;  // grid cells that a closing bridges to each side

// Grid cells with a marked one at most kReach rows and columns away; none exist beyond the border.
Mask dilated(const Mask& mask) {
  Mask across = Mask::Constant(mask.rows(), mask.cols(), false), both = across;
  for (Index d = -kReach; d <= kReach; ++d) {
    const Index n = mask.cols() - std::abs(d);
    if (n > 0)
      across.middleCols(std::max<Index>(0, d), n) =
          across.middleCols(std::max<Index>(0, d), n) || mask.middleCols(std::max<Index>(0, -d), n);
  }
  for (Index d = -kReach; d <= kReach; ++d) {
    const Index n = mask.rows() - std::abs(d);
    if (n > 0)
      both.middleRows(std::max<Index>(0, d), n) =
          both.middleRows(std::max<Index>(0, d), n) || across.middleRows(std::max<Index>(0, -d), n);
  }
  return both;
}

}  // namespace

Eigen::ArrayXd area_weights(const HeightMap& map, const std::vector<Index>& known,
                            const std::vector<Index>& fitted) {
  const Index rows = map.rows(), columns = map.columns();
  Mask has_point = Mask::Constant(rows, columns, false);
  for (const Index at : known) has_point.data()[at] = true;
  // Closing is dilation, then erosion; erosion is the dilation of the complement.
  const Mask closed = !dilated(!dilated(has_point));

  Grid weight = Grid::Ones(rows, columns);
  std::vector<double*> beside;
  for (Index row = 0; row < rows; ++row) {
    for (Index column = 0; column < columns; ++column) {
      if (has_point(row, column) || !closed(row, column)) continue;
      beside.clear();
      for (Index j = std::max<Index>(0, row - 1); j <= std::min(rows - 1, row + 1); ++j)
        for (Index i = std::max<Index>(0, column - 1); i <= std::min(columns - 1, column + 1); ++i)
          if (has_point(j, i)) beside.push_back(&weight(j, i));
      for (double* share : beside) *share += 1.0 / double(beside.size());
    }
  }
  Eigen::ArrayXd weights(Index(fitted.size()));
  for (Index i = 0; i < weights.size(); ++i) weights[i] = weight.data()[fitted[std::size_t(i)]];
  return weights / weights.mean();
}

}  // namespace aberfit::internal
