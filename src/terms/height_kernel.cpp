#include "height_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/height_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

void zernike_heights(InstructionSet set, int m_max, const int* first, const double* recurrence, bool folded,
                     const OrbitBlock& block, double* basis, double* sums) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::zernike(m_max, first, recurrence, folded, block, basis, sums);
  if (set == InstructionSet::kAvx2)
    return avx2::zernike(m_max, first, recurrence, folded, block, basis, sums);
#endif
  static_cast<void>(set);
  baseline::zernike(m_max, first, recurrence, folded, block, basis, sums);
}

void fourier_heights(InstructionSet set, int modes, const double* frequency, bool folded,
                     const OrbitBlock& block, double* basis, double* sums) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::fourier(modes, frequency, folded, block, basis, sums);
  if (set == InstructionSet::kAvx2) return avx2::fourier(modes, frequency, folded, block, basis, sums);
#endif
  static_cast<void>(set);
  baseline::fourier(modes, frequency, folded, block, basis, sums);
}

void add_height_products(InstructionSet set, int rows, const double* basis, const OrbitBlock& block,
                         double* sums) {
  const long stride = block.columns;
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::products(rows, basis, block, block.weights[0], sums, stride);
  if (set == InstructionSet::kAvx2) return avx2::products(rows, basis, block, block.weights[0], sums, stride);
#endif
  static_cast<void>(set);
  baseline::products(rows, basis, block, block.weights[0], sums, stride);
}

}  // namespace aberfit::internal
