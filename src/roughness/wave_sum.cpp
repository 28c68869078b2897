#include "wave_sum.h"

#define ABERFIT_KERNEL_BODY "../roughness/wave_sum_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

double wave_sum(double r, double y, const double* data, const int* pairs, int blocks, InstructionSet set) {
  return ABERFIT_KERNEL(set, wave_sum)(r, y, data, pairs, blocks);
}

}  // namespace aberfit::internal
