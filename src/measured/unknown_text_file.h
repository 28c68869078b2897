#pragma once
#include "aberfit/measured/read_measurement.h"

namespace aberfit::internal {

/// Throws InputError that says why a file of text or an empty file has no format that is known: the line that
/// is no row of numbers, or that there is none. Returns for a binary file.
void refuse_unknown_text(const MeasuredSource& source);

}  // namespace aberfit::internal
