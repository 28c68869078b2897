#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "aberfit/terms/surface_operator.h"

namespace aberfit::internal {

/// L^T of height weights on the cells of a fine grid, by sums over blocks of cells. Wave optics needs far
/// more cells than terms do, and a term is nearly constant over a small block (height_block_side.h). Near the
/// rim, the radial waves of Zernikes become as short as the root of the distance; cells there count
/// individually.
class HeightBlocks {
 public:
  /// Grid cells along the side of a block: height_block_side, or one less where an even block would not
  /// include the middle cell of an odd grid.
  static int side(const TermSet& terms, const PupilSample& cells);

  /// cells: points of a CartesianGrid or a DirectionGrid, else std::invalid_argument.
  HeightBlocks(const TermSet& terms, const PupilSample& cells, int side, const OperatorOptions& options);

  /// Sums weights of cells: one sum for each block, each cell at the rim and each term of a segment.
  Eigen::ArrayXd sums(const Eigen::ArrayXd& weights) const;
  /// The products of terms and weights (terms x weights), from the `sums` of each.
  Eigen::MatrixXd products(std::span<const Eigen::ArrayXd> sums) const;

 private:
  std::vector<std::uint32_t> place_;  // index of each cell in the sums: blocks, then cells
  Eigen::Index blocks_ = 0, at_rim_ = 0, terms_ = 0;
  std::unique_ptr<const SurfaceOperator> of_blocks_, of_cells_;  // null without any
  std::unique_ptr<const SurfaceOperator> of_segments_;           // of all cells; null without any
};

}  // namespace aberfit::internal
