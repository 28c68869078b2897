#pragma once
#include <optional>

#include "aberfit/method/trace_surface.h"

namespace aberfit::internal {

/// The given surface, or the study's terms with its seeded draw.
GivenSurface surface_of(const Task& task, const Groundwork& ground, const std::optional<GivenSurface>& given);

/// Heights and slopes at the pupil points by the study's normals: analytic, or central differences.
SurfaceField surface_field(const Task& task, const PupilSample& pupil, const GivenSurface& surface,
                           int threads);

}  // namespace aberfit::internal
