#include "fourier_kernel.h"

#include <numbers>

#define ABERFIT_KERNEL_BODY "../terms/fourier_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

FourierRows fourier_rows(const std::vector<FourierMode>& modes) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  FourierRows rows;
  rows.frequency.reserve(4 * modes.size());
  for (const FourierMode& mode : modes)
    rows.frequency.insert(rows.frequency.end(), {mode.fx, mode.fy, kTwoPi * mode.fx, kTwoPi * mode.fy});
  return rows;
}

void fourier_forward(InstructionSet set, const FourierRows& rows, const double* amplitudes,
                     PointBlock* block) {
  ABERFIT_KERNEL(set, forward)(rows.modes(), rows.frequency.data(), amplitudes, block);
}

void fourier_adjoint(InstructionSet set, const FourierRows& rows, const PointBlock& block,
                     double* amplitudes) {
  ABERFIT_KERNEL(set, adjoint)(rows.modes(), rows.frequency.data(), block, amplitudes);
}

}  // namespace aberfit::internal
