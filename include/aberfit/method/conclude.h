#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// Completes the result of a fit: the verdict by the physics that the scene needs, the spread of single
/// mirrors, the numbers and the character of the surface, its band, and the warnings that follow.
void conclude(const FitCase& of, Attempt* attempt);

}  // namespace aberfit
