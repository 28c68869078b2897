#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// What the spiders of a description leave of its shape; of a mask, of its outlines.
Aperture clear_of(const ApertureSpec& spec, const SegmentedAperture& of_mask);
/// Whether that is more than a millionth.
bool leaves_something(const ApertureSpec& spec, const SegmentedAperture& of_mask);

}  // namespace aberfit::internal
