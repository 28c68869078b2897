#include "polar_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/polar_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void polar_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, double slope_unit,
                   const RingBlock& rings, RingOrder* orders) {
  auto* const forward = ABERFIT_KERNEL(set, forward);
  forward(rows.m_max(), rows.first.data(), rows.recurrence.data(), packed, slope_unit, rings, orders);
}

void polar_adjoint(InstructionSet set, const ZernikeRows& rows, double slope_unit, const RingBlock& rings,
                   const RingOrder* orders, std::vector<CacheLine>* lanes, double* packed) {
  if (rows.rows() == 0) return;
  double* const sums = lane_sums(rows, lanes);
  auto* const adjoint = ABERFIT_KERNEL(set, adjoint);
  adjoint(rows.m_max(), rows.first.data(), rows.recurrence.data(), slope_unit, rings, orders, sums, packed);
}

}  // namespace aberfit::internal
