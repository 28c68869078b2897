#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit::internal {

/// Pitch [m] of a grid fine enough for all targets, times `coarsening`; 0 by rays. Throws as wave_pitch.
double grid_pitch(const FitCase& of, const TermSet& terms, double coarsening);

}  // namespace aberfit::internal
