#pragma once
#include <string>

#include "aberfit/core/units.h"
#include "aberfit/specify/solve.h"

namespace aberfit::internal {

/// What a number is called in SI units, after its name: "_m".
std::string unit_suffix(Dimension dimension);
/// What people call a number of the roughness: "rms", "rms of polishing".
std::string name_of(const SolveUnknown& unknown);
/// Its column in a table: its pointer without the block it is in, "parts/0/rms", and its unit.
std::string column_of(const SolveUnknown& unknown);
/// "17.0134 nm".
std::string six_digits(double value, Dimension dimension);

}  // namespace aberfit::internal
