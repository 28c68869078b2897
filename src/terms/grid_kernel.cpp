#include "grid_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/grid_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

void grid_forward(InstructionSet set, const FourierRows& rows, const double* amplitudes, GridTile* tile) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::forward(rows.modes(), rows.frequency.data(), amplitudes, tile);
  if (set == InstructionSet::kAvx2)
    return avx2::forward(rows.modes(), rows.frequency.data(), amplitudes, tile);
#endif
  static_cast<void>(set);
  baseline::forward(rows.modes(), rows.frequency.data(), amplitudes, tile);
}

void grid_adjoint(InstructionSet set, const FourierRows& rows, GridTile* tile, double* amplitudes) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::adjoint(rows.modes(), rows.frequency.data(), tile, amplitudes);
  if (set == InstructionSet::kAvx2)
    return avx2::adjoint(rows.modes(), rows.frequency.data(), tile, amplitudes);
#endif
  static_cast<void>(set);
  baseline::adjoint(rows.modes(), rows.frequency.data(), tile, amplitudes);
}

}  // namespace aberfit::internal
