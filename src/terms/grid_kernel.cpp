#include "grid_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/grid_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void grid_forward(InstructionSet set, const FourierRows& rows, const double* amplitudes, GridTile* tile) {
  ABERFIT_KERNEL(set, forward)(rows.modes(), rows.frequency.data(), amplitudes, tile);
}

void grid_adjoint(InstructionSet set, const FourierRows& rows, GridTile* tile, double* amplitudes) {
  ABERFIT_KERNEL(set, adjoint)(rows.modes(), rows.frequency.data(), tile, amplitudes);
}

}  // namespace aberfit::internal
