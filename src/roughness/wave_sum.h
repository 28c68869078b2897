#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Block length of `wave_sum`, a multiple of every vector length.
constexpr int kWaveBlock = 16;

/// sum_i (y B_i(y^2) (cos p_i + sin p_i) - A_i(y^2) (sin p_i - cos p_i)), p_i = 2 pi r f_i, with polynomials
/// A and B. data: for each block 16 frequencies, then pairs[block] times 16 coefficients of A and 16 of B,
/// constant terms first. The absolute error of a wave is 2e-15 + 1e-15 r f of its amplitude.
double wave_sum(double r, double y, const double* data, const int* pairs, int blocks,
                InstructionSet set = best_instruction_set());

}  // namespace aberfit::internal
