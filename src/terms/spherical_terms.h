#pragma once
#include <vector>

#include "point_block.h"

namespace aberfit::internal {

/// Spherical terms (rho / radius)^p, p even; the coefficient is the height at the rim [m]. Coordinates are in
/// units of the radius, and slopes are derivatives with respect to them.

/// Adds the terms and their gradients to the block's field.
void spherical_forward(const std::vector<int>& powers, const double* coefficients, PointBlock* block);

/// Adds the weighted sums over the block to `coefficients`: the transpose of spherical_forward.
void spherical_adjoint(const std::vector<int>& powers, const PointBlock& block, double* coefficients);

}  // namespace aberfit::internal
