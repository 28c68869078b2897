#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "aberfit/core/units.h"
#include "aberfit/measured/profile.h"
#include "aberfit/measured/read_measurement.h"
#include "text_columns.h"

namespace aberfit::internal {

/// Name of a column taken apart: "height_nm", "height (nm)", "height [nm]", "height/nm", "height nm" ->
/// "height", "nm". The word is in lower case; the unit is empty when there is none.
struct ColumnName {
  std::string word, unit;
};
/// Nothing where the table has no names.
ColumnName column_name(const TextTable& table, std::size_t column);

/// What a word or a title says: "slope", "dz/dx" -> slope; "height", "sag", "z" ... -> height.
std::optional<ProfileQuantity> quantity_of_word(const std::string& word);

/// SI units in one `unit` of height: a length; "waves" times the wavelength. `pointer` goes into the message:
/// where the unit stands. Throws InputError.
double height_factor(const std::string& unit, const MeasuredSource& source, const TextTable& table,
                     const std::string& pointer);
/// SI units in one `unit` of the dimension. `more`: what else the message allows. Throws InputError.
double factor_or_fail(const std::string& unit, Dimension dimension, const TextTable& table,
                      const std::string& pointer, const std::string& more = "");

/// The factor of the option `x_unit` or `value_unit`, which must be given, beside the file's `unit`, which
/// may be empty or unknown. Throws InputError where they contradict each other.
double x_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit);
double value_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit,
                           ProfileQuantity quantity);

/// True for a wavefront: "# of: surface" or "# of: wavefront", else the option; nothing when neither says it.
/// Throws InputError where they contradict each other.
std::optional<bool> is_wavefront(const MeasuredSource& source, const TextTable& table);

/// A positive length [m] after "# key:"; nothing without the key. Throws InputError.
std::optional<double> length_key(const TextTable& table, const std::string& key);
/// Value of a key, or nothing.
std::optional<std::string> key_value(const TextTable& table, const std::string& key);

}  // namespace aberfit::internal
