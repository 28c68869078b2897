#pragma once
#include "visitor.h"

namespace aberfit::internal {

inline constexpr Dimension kLength = Dimension::kLength;
inline constexpr Dimension kFrequency = Dimension::kSpatialFrequency;
inline constexpr Dimension kNumber = Dimension::kNumber;
inline constexpr Need kRequired = Need::kRequired;
inline constexpr Need kOptional = Need::kOptional;

}  // namespace aberfit::internal
