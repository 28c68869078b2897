#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit {

/// The `target` block.
void describe_target(Visitor& v, TargetSpec& target);

}  // namespace aberfit
