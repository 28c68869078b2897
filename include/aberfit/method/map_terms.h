#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// The terms that a task fits to a map of its mirror. Without a named order those of a part with a named cut
/// end there. Throws FieldError for Fourier terms and for a cut beyond the order that law::kLargestOrder
/// says.
TermSet map_terms(const Task& task);

/// Least squares of these terms to a map about the axis of the aperture, NaN outside it. `warnings` gets
/// where the map is smaller than the aperture, and those of the fit; light and statistics are left out.
/// Throws FieldError for an aperture that the map is too small or has too many points for.
FitOutcome fit_map_terms(const Task& task, const HeightMap& map, const MapFitOptions& how,
                         const RunContext& context);

/// Adds the light of the map and of its terms (map_light). with_ring: the width of a ring through the focus,
/// too. Throws Interrupted where the run is asked to stop.
void light_up_map(const Task& task, const HeightMap& map, bool with_ring, const RunContext& context,
                  FitOutcome* outcome);

/// Adds the focal statistics of the terms of a map that has no specification to be judged by: by rays or
/// waves as a scene without roughness has it, by waves where rays would draw a spot that light does not make;
/// and the light, as above. pupil: rays; field: the terms at them. Throws FieldError for waves that are asked
/// for where there are none.
void describe_map(const Task& task, const HeightMap& map, const PupilSample& pupil, const SurfaceField& field,
                  const RunContext& context, FitOutcome* outcome);

}  // namespace aberfit
