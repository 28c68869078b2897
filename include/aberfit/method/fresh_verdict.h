#pragma once
#include <cstdint>

#include "aberfit/method/attempt.h"

namespace aberfit {

/// Computes the statistics on points that the fit has not used, and the verdict on them. rays: their number;
/// 0: four times that of the fit. Waves first use a grid up to twice as coarse as the safe one
/// (pupil_choice.h). Targets left undecided by its error go to finer grids, up to the safe one.
void judge_on_fresh_rays(const FitCase& of, Attempt* attempt, std::int64_t rays = 0);

}  // namespace aberfit
