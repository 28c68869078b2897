#include "spherical_terms.h"

#include <Eigen/Core>

namespace aberfit::internal {
namespace {

using BlockArray = Eigen::Array<double, kBlockPoints, 1>;
using BlockMap = Eigen::Map<BlockArray, Eigen::Aligned64>;
using ConstBlockMap = Eigen::Map<const BlockArray, Eigen::Aligned64>;

/// rho^(p-2). The term is rho^2 times this, its gradient p (x, y) times this; there is no division by rho.
BlockArray power_below(const BlockArray& rho_squared, int p) {
  BlockArray below = BlockArray::Ones();
  for (int i = 2; i < p; i += 2) below *= rho_squared;
  return below;
}

}  // namespace

void spherical_forward(const std::vector<int>& powers, const double* coefficients, PointBlock* block) {
  const ConstBlockMap x(block->x), y(block->y);
  BlockMap height(block->height), slope_x(block->slope_x), slope_y(block->slope_y);
  const BlockArray rho_squared = x.square() + y.square();
  for (std::size_t j = 0; j < powers.size(); ++j) {
    const BlockArray below = coefficients[j] * power_below(rho_squared, powers[j]);
    height += below * rho_squared;
    slope_x += double(powers[j]) * below * x;
    slope_y += double(powers[j]) * below * y;
  }
}

void spherical_adjoint(const std::vector<int>& powers, const PointBlock& block, double* coefficients) {
  const ConstBlockMap x(block.x), y(block.y);
  const ConstBlockMap height(block.height), slope_x(block.slope_x), slope_y(block.slope_y);
  const BlockArray rho_squared = x.square() + y.square();
  const BlockArray from_height = height * rho_squared, from_slope = slope_x * x + slope_y * y;
  for (std::size_t j = 0; j < powers.size(); ++j)
    coefficients[j] +=
        (power_below(rho_squared, powers[j]) * (from_height + double(powers[j]) * from_slope)).sum();
}

}  // namespace aberfit::internal
