#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"
#include "statistic_request.h"

namespace aberfit::internal {

/// Throws FieldError where a larger given circle in one plane holds less energy than a smaller one.
void check_given_energies(const std::vector<Wanted>& wanted);

}  // namespace aberfit::internal
