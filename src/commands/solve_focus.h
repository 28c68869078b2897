#pragma once
#include <vector>

#include "aberfit/specify/solve.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The numbers that the study's `solve` block looks for, with their starts. Throws InputError for a pointer
/// to anything else.
std::vector<SolveUnknown> solve_unknowns(const Study& study);

}  // namespace aberfit::internal
