#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// The terms that a task fits to a map of its mirror. For a part with a named cut and no named order, they
/// end at the cut. Throws FieldError for Fourier terms and for a cut beyond law::kLargestOrder.
TermSet map_terms(const Task& task);

/// Least squares of these terms to a map about the axis of the aperture, NaN outside it. Irradiance and
/// statistics are left out. `warnings` gets those of the fit, and one where the map is smaller than the
/// aperture. Throws FieldError for an aperture that the map does not cover or that contains too many points.
FitOutcome fit_map_terms(const Task& task, const HeightMap& map, const MapFitOptions& how,
                         const RunContext& context);

/// Adds the wave-optics statistics of the map and of its terms (map_light). with_ring: includes the width of
/// a ring through the focus. Throws Interrupted where the run is stopped.
void light_up_map(const Task& task, const HeightMap& map, bool with_ring, const RunContext& context,
                  FitOutcome* outcome);

/// Adds the focal statistics of the terms of a map without a specification, and the results of map_light. The
/// model is that of a scene without roughness, or waves where rays would give a spot below the diffraction
/// limit. pupil: rays; field: the terms at them. Throws FieldError for impossible waves.
void describe_map(const Task& task, const HeightMap& map, const PupilSample& pupil, const SurfaceField& field,
                  const RunContext& context, FitOutcome* outcome);

}  // namespace aberfit
