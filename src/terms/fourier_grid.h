#pragma once
#include <cstdint>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/scene/pupil.h"
#include "fourier_kernel.h"
#include "grid_kernel.h"
#include "partial_sums.h"
#include "scratch_pool.h"
#include "term_operator.h"

namespace aberfit::internal {

/// Fourier part of L on (any subset of) a Cartesian grid. The phase factor of a mode at a point is that of
/// the column times that of the row, so h and its gradient are products of a rows x modes and a modes x
/// columns table. Tables are made anew per tile and block of modes, a few per cent of the work: nothing of
/// the size modes x rows is stored.
class FourierGrid : public TermOperator {
 public:
  FourierGrid(const TermSet& terms, const CartesianGrid& grid);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

 private:
  struct Span {
    int row, rows, column, columns;
  };
  void prepare(const Span& span, GridTile* tile) const;
  /// Calls visit(row in tile, column in tile, point) for the points of the tile.
  template <typename Visit>
  void for_points(const Span& span, const Visit& visit) const;

  FourierRows rows_;
  Eigen::Index begin_;  // first Fourier coefficient
  Eigen::ArrayXd x_, y_;
  // Points by row and within a row by column: numbers of the points, their columns, and where a row begins.
  std::vector<std::uint32_t> point_, column_;
  std::vector<std::size_t> row_begin_;
  std::vector<Span> tiles_;  // those that have points
  InstructionSet set_;
  mutable ScratchPool<GridTile> scratch_;
  mutable ScratchPool<PartialSums> sums_;
};

}  // namespace aberfit::internal
