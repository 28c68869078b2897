#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Replaces two uniform numbers in (0, 1) by two independent standard normal ones: sqrt(-2 ln u) times cosine
/// and sine of 2 pi v (Box and Muller 1958). count: a multiple of 8.
void box_muller(InstructionSet set, int count, double* u, double* v);

}  // namespace aberfit::internal
