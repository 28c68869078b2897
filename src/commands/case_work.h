#pragma once
#include <functional>

#include "aberfit/cases/run_cases.h"

namespace aberfit::internal {

/// Returns the function that a sweep calls for each case. It computes on one thread.
CaseWork case_work(CaseLevel level, const std::function<bool()>& interrupted);

}  // namespace aberfit::internal
