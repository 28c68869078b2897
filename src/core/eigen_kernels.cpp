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

const EigenKernels& eigen_kernels(InstructionSet set) { return ABERFIT_KERNEL(set, kEigenKernels); }

}  // namespace aberfit::internal
