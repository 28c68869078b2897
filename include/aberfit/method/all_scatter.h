#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// Draws behind a verdict without terms: more where these spread too far to tell, up to the most.
inline constexpr int kScatterDraws = 16, kMostScatterDraws = 64;
/// Of heights and slopes, which few low frequencies carry and which need no light: more, and cheaply.
inline constexpr int kMostDrawnSurfaces = 2048;
/// Cycles across the aperture up to which such a draw is a surface; what is above, mirrors differ less in.
inline constexpr double kDrawnCycles = 24;
inline constexpr int kDrawnWaves = 1200;  ///< that such a surface has at most, about

/// The roughness of such a draw: below is the surface's, above the mean's.
std::shared_ptr<const BandSplit> drawn_split(const Task& task, const Groundwork& ground);
/// The plane waves of its surface.
TermSet drawn_waves(const Groundwork& ground, const BandSplit& split);

/// Where no frequency needs a term (the split at the bottom of the band): nothing is fitted, the surface is
/// the mirror without roughness with all of it as scatter. Generalised Harvey-Shack would then be judged
/// against itself; instead its targets are judged on the mean of kScatterDraws or more drawn mirrors of the
/// whole PSD, with Student's t, each draw a surface of plane waves up to kDrawnCycles across and the rest as
/// its mean.
Attempt judge_all_scatter(const FitCase& of);

}  // namespace aberfit
