#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// Why no study may ask for them any more.
inline constexpr const char* kConvolvedRemoved =
    "rays convolved with the diffraction pattern were removed: they miss ee35 in focus by 13 % in an "
    "ordinary "
    "scene and save a third of the time of waves only";

/// The `target` block: statistics and PSD bins, or a map.
void describe_target(Visitor& v, TargetSpec& target, std::optional<MapTarget>& map);

}  // namespace aberfit::internal
