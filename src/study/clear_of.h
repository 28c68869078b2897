#pragma once
#include <optional>

#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The shape of a description less what its spiders cover; for a mask the shape is `of_mask`, its outlines.
/// Nothing where they leave a millionth or less.
std::optional<Aperture> clear_of(const ApertureSpec& spec, const SegmentedAperture& of_mask);

}  // namespace aberfit::internal
