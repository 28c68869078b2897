#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// The `roughness` block.
void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness);
/// The keys of its `psd` object.
void describe_psd_block(Visitor& v, RoughnessModel& node);

}  // namespace aberfit::internal
