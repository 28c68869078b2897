#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// What is said of a fit once it is done: the verdict by the physics that the scene needs, how far single
/// mirrors differ, the surface by its own numbers and its character, the band it stands for, and the warnings
/// that follow from all of it.
void conclude(const FitCase& of, Attempt* attempt);

}  // namespace aberfit
