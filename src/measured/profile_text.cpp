#include <fmt/format.h>

#include <algorithm>

#include "aberfit/core/errors.h"
#include "aberfit/measured/read_measurement.h"
#include "file_options.h"
#include "text_columns.h"
#include "text_columns_names.h"
#include "text_columns_profile.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostColumns = 10000;

std::string column_pointer(std::size_t column, const ColumnName& name) {
  return name.word.empty() ? fmt::format("column {}", column + 1)
                           : fmt::format("column {} {}", column + 1, in_quotes(name.word));
}

bool unit_measures(const std::string& unit, ProfileQuantity quantity, const MeasuredSource& source,
                   const TextTable& table) {
  try {
    if (quantity == ProfileQuantity::kSlope)
      factor_or_fail(unit, Dimension::kAngle, table, "");
    else if (lower_case(unit).substr(0, 4) != "wave")  // a height, even if the wavelength is unknown
      height_factor(unit, source, table, "");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

// The quantity comes from the option, otherwise from the column name, "# quantity:", or the unit.
ProfileQuantity quantity_of(const MeasuredSource& source, const TextTable& table, const ColumnName& name,
                            const std::string& pointer) {
  if (source.quantity) return *source.quantity;
  if (const auto said = quantity_of_word(name.word)) return *said;
  if (const auto key = key_value(table, "quantity")) {
    if (const auto said = quantity_of_word(*key)) return *said;
    fail_at_line(table.path, table.keys.at("quantity").line, in_quotes(*key), "height or slope");
  }
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    if (!name.unit.empty() && unit_measures(name.unit, quantity, source, table)) return quantity;
  throw MissingFact(
      "quantity", table.path, pointer, "no statement whether it holds heights or slopes",
      "the option 'quantity', or a header row such as 'x_mm, height_nm' or 'x (mm), slope (urad)'");
}

double value_factor_of(const MeasuredSource& source, const TextTable& table, const ColumnName& name,
                       ProfileQuantity quantity, bool chosen, const std::string& pointer) {
  const std::string unit = name.unit.empty() ? key_value(table, "unit").value_or("") : name.unit;
  if ((source.value_factor || source.value_in_waves) && (chosen || unit.empty()))
    return value_factor_beside(source, table, unit, quantity);
  if (unit.empty())
    throw MissingFact("value_unit", table.path, pointer, "values without unit",
                      "the option 'value_unit', or a header row such as 'x_mm, height_nm'");
  if (quantity == ProfileQuantity::kHeight) return height_factor(unit, source, table, pointer);
  return factor_or_fail(unit, Dimension::kAngle, table, pointer);
}

double x_factor_of(const MeasuredSource& source, const TextTable& table, const ColumnName& name) {
  const std::string unit = name.unit.empty() ? key_value(table, "x_unit").value_or("") : name.unit;
  if (source.x_factor) return x_factor_beside(source, table, unit);
  const std::string pointer = column_pointer(0, name);
  // The given distance of the rows also determines the unit of their positions.
  if (const double step = mean_step(table, {}); unit.empty() && source.pitch && step > 0)
    return *source.pitch / step;
  if (unit.empty())
    throw MissingFact("x_unit", table.path, pointer, "positions without unit",
                      "the option 'x_unit', or a header row such as 'x_mm, height_nm'");
  return factor_or_fail(unit, Dimension::kLength, table, pointer);
}

// Adds positions in equal steps [m] from 0 to a table of values alone.
void add_positions(double pitch, TextTable* table) {
  std::vector<double> values;
  for (std::size_t row = 0; row < table->rows(); ++row)
    values.insert(values.end(), {double(row) * pitch, (*table)(row, 0)});
  table->values = std::move(values);
  table->columns = 2;
  if (!table->names.empty()) table->names.insert(table->names.begin(), "x [m]");
  table->keys.erase("x_unit");
}

}  // namespace

std::vector<Profile> read_profile_text(const MeasuredSource& source) {
  check_option(source, source.x_factor, "x_unit", true);
  check_option(source, source.value_factor, "value_unit", false);
  check_option(source, source.pitch, "pitch", true);
  TextTable table = read_text_table(source.path, {});
  if (table.columns < 2 && source.pitch && !source.x_factor) add_positions(*source.pitch, &table);
  if (table.columns < 2)
    fail_at_line(
        table.path, table.lines.front(), "1 column",
        "at least 2 columns (position, value, further scan lines), or 1 of values in equal steps with the "
        "option 'pitch'; rows of a map that continue over several lines need the option 'columns'");
  if (table.columns > kMostColumns)
    fail_at_line(table.path, table.lines.front(), fmt::format("{} columns", table.columns),
                 fmt::format("at most {} columns; read a matrix of heights as a map", kMostColumns));
  if (table.rows() < 2) throw InputError(table.path, "", "1 row of numbers", "at least 2 rows of numbers");
  const auto name = [&](std::size_t column) { return column_name(table, column); };
  ProfileColumns columns;
  columns.pitch = source.pitch.value_or(0);
  columns.x_factor = x_factor_of(source, table, name(0));
  const double halve = surface_per_height(is_wavefront(source, table).value_or(false));
  std::vector<Profile> profiles;
  for (std::size_t column = 1; column < table.columns; ++column) {
    const std::string pointer = column_pointer(column, name(column));
    columns.value = column;
    columns.quantity = quantity_of(source, table, name(column), pointer);
    // The options apply to the chosen scan line.
    const bool chosen = column == std::size_t(std::max(1, source.column));
    columns.value_factor =
        halve * value_factor_of(source, table, name(column), columns.quantity, chosen, pointer);
    profiles.push_back(profile_of(table, columns));
    const std::string title = table.names.empty() ? "" : table.names[column];
    profiles.back().label = key_value(table, "label").value_or(title);
  }
  return profiles;
}

}  // namespace aberfit
