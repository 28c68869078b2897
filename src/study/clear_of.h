#pragma once
#include <optional>

#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The described shape without the parts that its spiders cover. of_mask: the outlines of a mask, if the
/// shape is one. Returns nothing if at most a millionth of the area is left.
std::optional<Aperture> clear_of(const ApertureSpec& spec, const SegmentedAperture& of_mask);

}  // namespace aberfit::internal
