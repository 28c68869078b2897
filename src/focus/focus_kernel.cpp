#include "focus_kernel.h"

#define ABERFIT_KERNEL_BODY "../focus/focus_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

const FocusKernels& focus_kernels(InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::kKernels;
  if (set == InstructionSet::kAvx2) return avx2::kKernels;
#endif
  static_cast<void>(set);
  return baseline::kKernels;
}

}  // namespace aberfit::internal
