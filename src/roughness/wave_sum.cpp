#include "wave_sum.h"

#define ABERFIT_KERNEL_BODY "../roughness/wave_sum_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

double wave_sum(double r, double y, const double* data, const int* pairs, int blocks, InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::wave_sum(r, y, data, pairs, blocks);
  if (set == InstructionSet::kAvx2) return avx2::wave_sum(r, y, data, pairs, blocks);
#endif
  static_cast<void>(set);
  return baseline::wave_sum(r, y, data, pairs, blocks);
}

}  // namespace aberfit::internal
