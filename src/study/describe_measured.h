#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// The keys of `psd.model: "measured"`; also the options of `aberfit psd FILE`.
void describe_measured_psd(Visitor& v, MeasuredPsd& measured);
/// The keys of target.map.
void describe_map_target(Visitor& v, MapTarget& target);

/// Reports `key` unless `unit` is one of the dimension's.
void check_unit(Visitor& v, const char* key, const std::string& unit, Dimension dimension);

}  // namespace aberfit::internal
