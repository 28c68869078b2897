#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit {

/// The `target` block: statistics and PSD bins, or a map.
void describe_target(Visitor& v, TargetSpec& target, std::optional<MapTarget>& map);

}  // namespace aberfit
