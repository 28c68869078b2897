#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "aberfit/core/units.h"

namespace aberfit::internal {

/// Units of the first two columns of a table, as its header writes them; empty where it does not.
struct HeaderUnits {
  std::string frequency, psd;
};

/// What a row of names says: "f [1/mm], PSD [nm^2 mm^2]", "f_per_mm,psd_nm2_mm2", "f (cycles/mm);S (um^4)",
/// or a row of units alone, "[1/mm];[m^4]". A unit is told as such when it is one of a frequency, or of a PSD
/// of either kind; what else stands in brackets is no unit here.
HeaderUnits units_of_header(std::string_view row);

/// The factor to SI of a unit; nothing for a text that is no unit of that dimension.
std::optional<double> factor_of(const std::string& unit, Dimension dimension);

}  // namespace aberfit::internal
