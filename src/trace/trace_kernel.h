#pragma once
#include "aberfit/core/instruction_set.h"
#include "aberfit/scene/mirror.h"

namespace aberfit::internal {

/// Rays one kernel call works on; a multiple of every vector length.
constexpr int kTraceBlock = 512;

/// Surface error of a run of points [m], slopes; all null for the mirror alone.
struct FieldRun {
  const double *height, *slope_x, *slope_y;
};
/// Where the rays of a run go: the arrays of a RayBundle.
struct RayRun {
  double *x, *y, *tx, *ty, *weight;
};
/// Gradient over the rays of a run and, in `height` ..., over the surface error.
struct AdjointRun {
  const double *d_x, *d_y, *d_tx, *d_ty;
  double *height, *slope_x, *slope_y;
};

/// `base_surface` of a mirror without known Zernikes (they come with the field) and `reflect` for `count`
/// points, a multiple of 8, with the processor's vectors; these templates are the definition. Returns the
/// number of lost rays, whose entries are zero.
int trace_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
              const double* weight, const FieldRun& field, const RayRun& rays);

/// The transpose of its derivative for `count` points, a multiple of 8.
void adjoint_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
                 const FieldRun& field, const AdjointRun& adjoint);

}  // namespace aberfit::internal
