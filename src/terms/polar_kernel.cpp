#include "polar_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/polar_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {

void polar_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, double slope_unit,
                   const RingBlock& rings, RingOrder* orders) {
  const int m_max = rows.m_max();
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::forward(m_max, rows.first.data(), rows.recurrence.data(), packed, slope_unit, rings,
                           orders);
  if (set == InstructionSet::kAvx2)
    return avx2::forward(m_max, rows.first.data(), rows.recurrence.data(), packed, slope_unit, rings, orders);
#endif
  static_cast<void>(set);
  baseline::forward(m_max, rows.first.data(), rows.recurrence.data(), packed, slope_unit, rings, orders);
}

void polar_adjoint(InstructionSet set, const ZernikeRows& rows, double slope_unit, const RingBlock& rings,
                   const RingOrder* orders, std::vector<CacheLine>* lanes, double* packed) {
  const int m_max = rows.m_max();
  if (rows.rows() == 0) return;
  const std::size_t wanted = std::size_t(rows.longest()) * 2;
  if (lanes->size() < wanted) lanes->resize(wanted);
  double* sums = lanes->front().lane;
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::adjoint(m_max, rows.first.data(), rows.recurrence.data(), slope_unit, rings, orders, sums,
                           packed);
  if (set == InstructionSet::kAvx2)
    return avx2::adjoint(m_max, rows.first.data(), rows.recurrence.data(), slope_unit, rings, orders, sums,
                         packed);
#endif
  static_cast<void>(set);
  baseline::adjoint(m_max, rows.first.data(), rows.recurrence.data(), slope_unit, rings, orders, sums,
                    packed);
}

}  // namespace aberfit::internal
