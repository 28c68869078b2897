#pragma once
#include "aberfit/core/instruction_set.h"
#include "aberfit/scene/mirror.h"

namespace aberfit::internal {

/// Largest number of rays of one kernel call; a multiple of every vector length.
constexpr int kTraceBlock = 512;

/// Surface error of a run of points: height [m] and slopes; all null for the mirror alone.
struct FieldRun {
  const double *height, *slope_x, *slope_y;
};
/// Output arrays of a RayBundle for the rays of a run.
struct RayRun {
  double *x, *y, *tx, *ty, *weight;
};
/// Gradient over the rays of a run; the outputs `height` ... are the gradient over the surface error.
struct AdjointRun {
  const double *d_x, *d_y, *d_tx, *d_ty;
  double *height, *slope_x, *slope_y;
};

/// `base_surface` of a mirror without known Zernikes (the field contains them) and `reflect` for `count`
/// points, a multiple of 8, with vector instructions. These two templates are the definition. Returns the
/// number of lost rays, whose entries are zero.
int trace_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
              const double* weight, const FieldRun& field, const RayRun& rays);

/// The transpose of the derivative of `trace_run` for `count` points, a multiple of 8.
void adjoint_run(InstructionSet set, const Mirror& mirror, int count, const double* x, const double* y,
                 const FieldRun& field, const AdjointRun& adjoint);

}  // namespace aberfit::internal
