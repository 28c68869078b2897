#pragma once
#include <optional>

#include "aberfit/method/trace_surface.h"

namespace aberfit::internal {

/// The given surface, or the task's terms with its seeded draw.
GivenSurface surface_of(const Task& task, const Groundwork& ground, const std::optional<GivenSurface>& given);

/// Heights and slopes at the pupil points by the task's normals: analytic, or central differences.
SurfaceField surface_field(const Task& task, const PupilSample& pupil, const GivenSurface& surface,
                           int threads);

}  // namespace aberfit::internal
