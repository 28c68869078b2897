#pragma once
#include "aberfit/commands/run.h"

namespace aberfit {

/// The map, moved to the axis; the terms that are fitted to it.
HeightMap load_map(const Study& study);
TermSet map_terms(const Study& study, double radius);

/// Least-squares terms of the measured map in target.map, traced; what run_fit does for such a study.
ResultDocument run_map_fit(const Study& study, const RunOptions& options);

}  // namespace aberfit
