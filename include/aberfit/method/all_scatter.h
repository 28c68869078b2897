#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// The roughness of a mirror that is drawn without terms: below is the surface's, above the mean's.
std::shared_ptr<const BandSplit> drawn_split(const Task& task, const Groundwork& ground);
/// The plane waves of its surface.
TermSet drawn_waves(const Groundwork& ground, const BandSplit& split);

/// Where no frequency needs a term (the split at the bottom of the band): nothing is fitted, the surface is
/// the mirror without roughness with all of it as scatter. Generalised Harvey-Shack would then be judged
/// against itself; instead its targets are judged on the mean of law::kGroups or more drawn mirrors of the
/// whole PSD, with Student's t, each draw a surface of plane waves up to law::kDrawnCycles across and the
/// rest as its mean.
Attempt judge_all_scatter(const FitCase& of);

}  // namespace aberfit
