#include "dense_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/dense_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void dense_forward(InstructionSet set, int terms, const double* basis, const double* coefficients,
                   double* field) {
  ABERFIT_KERNEL(set, forward)(terms, basis, coefficients, field);
}

void dense_adjoint(InstructionSet set, int terms, const double* basis, const double* weights, double* lanes) {
  ABERFIT_KERNEL(set, adjoint)(terms, basis, weights, lanes);
}

}  // namespace aberfit::internal
