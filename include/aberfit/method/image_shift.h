#pragma once
#include <optional>

#include "aberfit/core/warning.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// The warning `image-off-axis` where the known aberrations of the mirror - tilt, coma - put the centroid of
/// its light so far from the nominal focus that ee50 about the focus is not what it is about the centroid,
/// within the study's margin: how far, what ee50 is about either, and the tilt that centres the light.
/// Nothing for statistics about the centroid. The first look is a trace of the nominal mirror; only where
/// that is off by enough the light is asked, a tenth of a second. Throws as GeneralisedHarveyShack does of
/// mirrors.
std::optional<Warning> image_shift_warning(const Task& task);

}  // namespace aberfit
