#pragma once
#include <string>

#include "aberfit/core/units.h"
#include "aberfit/specify/solve.h"

namespace aberfit::internal {

/// Suffix of a name for its SI unit: "_m".
std::string unit_suffix(Dimension dimension);
/// Name of a number of the roughness for people: "rms", "rms of polishing".
std::string name_of(const SolveUnknown& unknown);
/// Heading of its column: pointer without its block, "parts/0/rms", and unit.
std::string column_of(const SolveUnknown& unknown);
/// Value with six digits and unit: "17.0134 nm".
std::string six_digits(double value, Dimension dimension);

}  // namespace aberfit::internal
