#include "focus_kernel.h"

#define ABERFIT_KERNEL_BODY "../focus/focus_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

const FocusKernels& focus_kernels(InstructionSet set) { return ABERFIT_KERNEL(set, kKernels); }

}  // namespace aberfit::internal
