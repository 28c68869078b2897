#include "trace_kernel.h"

#define ABERFIT_KERNEL_BODY "../trace/trace_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {
int trace_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
              const double* weight, const FieldRun& field, const RayRun& rays) {
  const bool parabola = is_parabola(mirror);
  const double* spherical = mirror.spherical.data();
  return ABERFIT_KERNEL(set, trace_run)(parabola, mirror, spherical, count, x, y, weight, field, rays);
}

void adjoint_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
                 const FieldRun& field, const AdjointRun& adjoint) {
  const bool parabola = is_parabola(mirror);
  const double* spherical = mirror.spherical.data();
  ABERFIT_KERNEL(set, adjoint_run)(parabola, mirror, spherical, count, x, y, field, adjoint);
}

}  // namespace aberfit::internal
