#include "normal_kernel.h"

#define ABERFIT_KERNEL_BODY "../core/normal_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

void box_muller(InstructionSet set, int count, double* u, double* v) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::box_muller(count, u, v);
  if (set == InstructionSet::kAvx2) return avx2::box_muller(count, u, v);
#endif
  static_cast<void>(set);
  baseline::box_muller(count, u, v);
}

}  // namespace aberfit::internal
