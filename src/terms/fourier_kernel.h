#pragma once
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/terms/term_set.h"
#include "point_block.h"

namespace aberfit::internal {

/// Frequencies of the modes for the kernels: fx, fy [cycles/m] and 2 pi fx, 2 pi fy [rad/m] per mode.
struct FourierRows {
  std::vector<double> frequency;

  int modes() const { return int(frequency.size() / 4); }
};

FourierRows fourier_rows(const std::vector<FourierMode>& modes);

/// Adds sum_k A_k cos(2 pi f_k . x) + B_k sin(2 pi f_k . x) and its gradient to the block's field;
/// `amplitudes` holds A, B per mode. Sine and cosine use the phase in cycles minus the nearest half cycle
/// (exact), then polynomials on +-1/4 cycle with an error below 3e-15. The phase itself has the rounding
/// error of f . x, 2 pi |f . x| 1e-16.
void fourier_forward(InstructionSet set, const FourierRows& rows, const double* amplitudes,
                     PointBlock* block);

/// Adds the weighted sums over the block to `amplitudes`: the transpose of fourier_forward.
void fourier_adjoint(InstructionSet set, const FourierRows& rows, const PointBlock& block,
                     double* amplitudes);

}  // namespace aberfit::internal
