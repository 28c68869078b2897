#pragma once
#include <cstdint>

#include "aberfit/method/attempt.h"

namespace aberfit {

/// Statistics on points that the fit has not seen, and the verdict on them. rays: how many; 0 for four times
/// the fit's. Waves take a grid up to twice as coarse as the safe one first (pupil_choice.h); the targets
/// that its error leaves open go on to finer ones, up to the safe one.
void judge_on_fresh_rays(const FitCase& of, Attempt* attempt, std::int64_t rays = 0);

}  // namespace aberfit
