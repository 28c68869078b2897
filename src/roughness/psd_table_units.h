#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "aberfit/core/units.h"

namespace aberfit::internal {

/// Units of the first two columns of a table, as written in its header; empty if absent.
struct HeaderUnits {
  std::string frequency, psd;
};

/// Reads the units from a row of names: "f [1/mm], PSD [nm^2 mm^2]", "f_per_mm,psd_nm2_mm2", "f (cycles/mm);S
/// (um^4)", or a row of units alone, "[1/mm];[m^4]". Only units of a frequency or of a PSD of either kind
/// count; other text in brackets is ignored.
HeaderUnits units_of_header(std::string_view row);

/// The factor to SI of a unit; nothing if the text is not a unit of that dimension.
std::optional<double> factor_of(const std::string& unit, Dimension dimension);

}  // namespace aberfit::internal
