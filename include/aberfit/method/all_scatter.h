#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// The split of the roughness of a mirror without terms: random surface below, mean scatter above.
std::shared_ptr<const BandSplit> drawn_split(const Task& task, const Groundwork& ground);
/// The plane waves of that random surface.
TermSet drawn_waves(const Groundwork& ground, const BandSplit& split);

/// Verdict where the split at the bottom of the band leaves nothing to terms. Nothing is fitted: the surface
/// is the mirror without roughness, and all of the roughness is scatter. Judging generalised Harvey-Shack
/// against itself would show nothing. The targets are therefore judged on the mean of at least law::kGroups
/// random mirrors of the whole PSD, with Student's t. Each realisation is a surface of plane waves up to
/// law::kDrawnCycles cycles across; the rest enters as its mean scatter.
Attempt judge_all_scatter(const FitCase& of);

}  // namespace aberfit
