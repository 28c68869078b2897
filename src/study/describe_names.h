#pragma once
#include "visitor.h"

namespace aberfit::internal {

using enum Need;
using enum Dimension;
inline constexpr Dimension kFrequency = kSpatialFrequency;

}  // namespace aberfit::internal
