#pragma once
#include "aberfit/measured/read_measurement.h"

namespace aberfit::internal {

/// Throws InputError for a text file or an empty file of unknown format. The message gives the line that is
/// not a row of numbers, or states that the file has none. Returns for a binary file.
void refuse_unknown_text(const MeasuredSource& source);

}  // namespace aberfit::internal
