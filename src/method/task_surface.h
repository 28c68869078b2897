#pragma once
#include <optional>

#include "aberfit/method/trace_surface.h"

namespace aberfit::internal {

/// The given surface, or the task's terms with its seeded random coefficients.
GivenSurface surface_of(const Task& task, const Groundwork& ground, const std::optional<GivenSurface>& given);

/// Heights and slopes at the pupil points by the task's normals: analytic, or central differences.
SurfaceField surface_field(const Task& task, const PupilSample& pupil, const GivenSurface& surface,
                           int threads);

/// Warning `central-difference` with the RMS slope error of central differences over these points; nothing
/// with analytic normals. seen: the surface_field of the same points.
std::optional<Warning> central_difference_warning(const Task& task, const PupilSample& pupil,
                                                  const GivenSurface& surface, const SurfaceField& seen,
                                                  int threads);

}  // namespace aberfit::internal
