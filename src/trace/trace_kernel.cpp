#include "trace_kernel.h"

#define ABERFIT_KERNEL_BODY "../trace/trace_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit::internal {
int trace_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
              const double* weight, const FieldRun& field, const RayRun& rays) {
  const bool parabola = is_parabola(mirror);
  const double* spherical = mirror.spherical.data();
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::trace_run(parabola, mirror, spherical, count, x, y, weight, field, rays);
  if (set == InstructionSet::kAvx2)
    return avx2::trace_run(parabola, mirror, spherical, count, x, y, weight, field, rays);
#endif
  static_cast<void>(set);
  return baseline::trace_run(parabola, mirror, spherical, count, x, y, weight, field, rays);
}

void adjoint_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
                 const FieldRun& field, const AdjointRun& adjoint) {
  const bool parabola = is_parabola(mirror);
  const double* spherical = mirror.spherical.data();
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512)
    return avx512::adjoint_run(parabola, mirror, spherical, count, x, y, field, adjoint);
  if (set == InstructionSet::kAvx2)
    return avx2::adjoint_run(parabola, mirror, spherical, count, x, y, field, adjoint);
#endif
  static_cast<void>(set);
  baseline::adjoint_run(parabola, mirror, spherical, count, x, y, field, adjoint);
}

}  // namespace aberfit::internal
