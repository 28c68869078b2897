#pragma once
#include <vector>

#include "point_block.h"

namespace aberfit::internal {

/// Spherical terms (rho / radius)^p, p even: coefficient = height at the rim [m]. Coordinates in units of the
/// radius; slopes are with respect to those. A handful of terms beside hundreds of others, so plain loops.

/// Adds the terms and their gradients to the block's field.
void spherical_forward(const std::vector<int>& powers, const double* coefficients, PointBlock* block);

/// Adds to `coefficients` the weighted sums over the block: the transpose of spherical_forward.
void spherical_adjoint(const std::vector<int>& powers, const PointBlock& block, double* coefficients);

}  // namespace aberfit::internal
