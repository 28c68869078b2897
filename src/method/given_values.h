#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"
#include "statistic_request.h"

namespace aberfit::internal {

/// Throws FieldError where given values of encircled energy in one plane contradict each other: no pattern
/// has less light in a larger circle.
void check_given_energies(const std::vector<Wanted>& wanted);

}  // namespace aberfit::internal
