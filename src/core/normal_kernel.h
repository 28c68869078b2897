#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Two independent standard normal numbers from two uniform ones in (0, 1), in place: sqrt(-2 ln u) times
/// cosine and sine of 2 pi v (Box and Muller 1958). count: a multiple of 8.
void box_muller(InstructionSet set, int count, double* u, double* v);

}  // namespace aberfit::internal
