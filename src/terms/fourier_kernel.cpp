#include "fourier_kernel.h"

#include <numbers>

#define ABERFIT_KERNEL_BODY "../terms/fourier_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

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
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::forward(rows.modes(), rows.frequency.data(), amplitudes, block);
  if (set == InstructionSet::kAvx2)
    return avx2::forward(rows.modes(), rows.frequency.data(), amplitudes, block);
#endif
  static_cast<void>(set);
  baseline::forward(rows.modes(), rows.frequency.data(), amplitudes, block);
}

void fourier_adjoint(InstructionSet set, const FourierRows& rows, const PointBlock& block,
                     double* amplitudes) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::adjoint(rows.modes(), rows.frequency.data(), block, amplitudes);
  if (set == InstructionSet::kAvx2)
    return avx2::adjoint(rows.modes(), rows.frequency.data(), block, amplitudes);
#endif
  static_cast<void>(set);
  baseline::adjoint(rows.modes(), rows.frequency.data(), block, amplitudes);
}

}  // namespace aberfit::internal
