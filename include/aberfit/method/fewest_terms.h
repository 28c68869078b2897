#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// `"terms": "auto"`: the fit of the fewest terms that meet every tolerance and are equivalent, with the
/// frontier of all that were tried; where none passes, of the set that comes nearest.
Attempt fit_fewest_terms(const Study& study, const Scene& scene, const TargetSets& targets,
                         const RunOptions& options, int threads);

}  // namespace aberfit
