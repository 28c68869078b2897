#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Points whose basis values lie together: per block and term kDensePoints heights, then as many slopes along
/// x, then along y. Products then read the basis once, in order.
constexpr int kDensePoints = 16;
constexpr int kDenseValues = 3 * kDensePoints;

/// Writes to field[kDenseValues] the sum over terms of coefficient times basis values of one block;
/// basis: terms x kDenseValues, on a 64-byte boundary.
void dense_forward(InstructionSet set, int terms, const double* basis, const double* coefficients,
                   double* field);

/// Adds to lanes[8 t ..] of each term t products of its basis values and the weights of one block (same order
/// as field); their sum over the eight is the term's.
void dense_adjoint(InstructionSet set, int terms, const double* basis, const double* weights, double* lanes);

}  // namespace aberfit::internal
