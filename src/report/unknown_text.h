#pragma once
#include <string>

#include "aberfit/core/units.h"
#include "aberfit/specify/solve.h"

namespace aberfit::internal {

/// What a number is called in SI units, after its name: "_m".
std::string unit_suffix(Dimension dimension);
/// Of a number of the roughness without the block it is in: "rms", "parts/0/B".
std::string name_of(const SolveUnknown& unknown);
/// "17.0134 nm".
std::string six_digits(double value, Dimension dimension);

}  // namespace aberfit::internal
