#include "dense_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/dense_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

void dense_forward(InstructionSet set, int terms, const double* basis, const double* coefficients,
                   double* field) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::forward(terms, basis, coefficients, field);
  if (set == InstructionSet::kAvx2) return avx2::forward(terms, basis, coefficients, field);
#endif
  static_cast<void>(set);
  baseline::forward(terms, basis, coefficients, field);
}

void dense_adjoint(InstructionSet set, int terms, const double* basis, const double* weights, double* lanes) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::adjoint(terms, basis, weights, lanes);
  if (set == InstructionSet::kAvx2) return avx2::adjoint(terms, basis, weights, lanes);
#endif
  static_cast<void>(set);
  baseline::adjoint(terms, basis, weights, lanes);
}

}  // namespace aberfit::internal
