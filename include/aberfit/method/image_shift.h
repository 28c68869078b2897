#pragma once
#include <optional>

#include "aberfit/core/warning.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// Warning `image-off-axis`: known aberrations of the mirror (tilt, coma) shift the centroid, and ee50 about
/// the nominal focus differs from ee50 about the centroid by more than the margin. The warning gives the
/// shift, both values of ee50, and the tilt that centres the image. No warning for statistics about the
/// centroid. A trace of the nominal mirror comes first; the wave-optics result (a tenth of a second) is
/// computed only if that trace shows a large enough shift. Throws as GeneralisedHarveyShack does for mirrors.
std::optional<Warning> image_shift_warning(const Task& task);

}  // namespace aberfit
