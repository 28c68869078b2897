#pragma once
#include <functional>

#include "aberfit/cases/run_cases.h"

namespace aberfit::internal {

/// What a sweep computes of each case, on one thread.
CaseWork case_work(CaseLevel level, const std::function<bool()>& interrupted);

}  // namespace aberfit::internal
