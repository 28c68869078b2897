#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit::internal {

/// Pitch of a grid as fine as the light of everything that is asked of it needs, times `coarsening` [m]; 0 by
/// rays. Throws ComputationError as wave_pitch does.
double grid_pitch(const FitCase& of, const TermSet& terms, double coarsening);

}  // namespace aberfit::internal
