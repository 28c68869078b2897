#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// The `roughness` block.
void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness);
/// The keys of its `psd` object.
void describe_psd_block(Visitor& v, RoughnessModel& node);

/// Reports `f_max` unless it is above `f_min`.
void require_band(Visitor& v, double f_min, double f_max);

}  // namespace aberfit::internal
