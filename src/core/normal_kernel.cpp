#include "normal_kernel.h"

#define ABERFIT_KERNEL_BODY "../core/normal_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void box_muller(InstructionSet set, int count, double* u, double* v) {
  ABERFIT_KERNEL(set, box_muller)(count, u, v);
}

}  // namespace aberfit::internal
