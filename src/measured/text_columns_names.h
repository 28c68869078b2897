#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "aberfit/core/units.h"
#include "aberfit/measured/profile.h"
#include "aberfit/measured/read_measurement.h"
#include "text_columns.h"

namespace aberfit::internal {

/// A column name split into word and unit: "height_nm", "height (nm)", "height [nm]", "height/nm", "height
/// nm" give "height", "nm". The word is in lower case; the unit may be empty.
struct ColumnName {
  std::string word, unit;
};
/// Returns an empty name if the table has no names.
ColumnName column_name(const TextTable& table, std::size_t column);

/// Returns the quantity of a word or title: "slope", "dz/dx" -> slope; "height", "sag", "z" ... -> height.
std::optional<ProfileQuantity> quantity_of_word(const std::string& word);

/// Returns the SI value of one `unit` of height: a length, or "waves", which use the wavelength. `pointer`:
/// place of the unit, for the message. Throws InputError.
double height_factor(const std::string& unit, const MeasuredSource& source, const TextTable& table,
                     const std::string& pointer);
/// Returns the SI value of one `unit`. `more`: other units that the message allows. Throws InputError.
double factor_or_fail(const std::string& unit, Dimension dimension, const TextTable& table,
                      const std::string& pointer, const std::string& more = "");

/// Return the factor of the option `x_unit` or `value_unit`, which must be given. `unit` is that of the file
/// and may be empty or unknown. Throw InputError if they contradict each other.
double x_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit);
double value_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit,
                           ProfileQuantity quantity);

/// Returns true for a wavefront: from "# of: surface" or "# of: wavefront", otherwise from the option;
/// nothing if neither exists. Throws InputError if they contradict each other.
std::optional<bool> is_wavefront(const MeasuredSource& source, const TextTable& table);

/// Returns the positive length [m] after "# key:"; nothing without the key. Throws InputError.
std::optional<double> length_key(const TextTable& table, const std::string& key);
/// Returns the value of a key, if any.
std::optional<std::string> key_value(const TextTable& table, const std::string& key);

}  // namespace aberfit::internal
