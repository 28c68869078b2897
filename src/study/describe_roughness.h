#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit {

/// The `roughness` block.
void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness);

}  // namespace aberfit
