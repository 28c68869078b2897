#include "height_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/height_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void zernike_heights(InstructionSet set, int m_max, const int* first, const double* recurrence, bool folded,
                     const OrbitBlock& block, double* basis, double* sums) {
  ABERFIT_KERNEL(set, zernike)(m_max, first, recurrence, folded, block, basis, sums);
}

void fourier_heights(InstructionSet set, int modes, const double* frequency, bool folded,
                     const OrbitBlock& block, double* basis, double* sums) {
  ABERFIT_KERNEL(set, fourier)(modes, frequency, folded, block, basis, sums);
}

void add_height_products(InstructionSet set, int rows, const double* basis, const OrbitBlock& block,
                         double* sums) {
  const long stride = block.columns;
  ABERFIT_KERNEL(set, products)(rows, basis, block, block.weights[0], sums, stride);
}

}  // namespace aberfit::internal
