#include "eigen_kernels.h"

namespace aberfit::internal {

#if ABERFIT_X86_KERNELS
namespace avx512 {
extern const EigenKernels kEigenKernels;
}
namespace avx2 {
extern const EigenKernels kEigenKernels;
}
#endif
namespace baseline {
extern const EigenKernels kEigenKernels;
}

const EigenKernels& eigen_kernels(InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::kEigenKernels;
  if (set == InstructionSet::kAvx2) return avx2::kEigenKernels;
#endif
  static_cast<void>(set);
  return baseline::kEigenKernels;
}

}  // namespace aberfit::internal
