#include "text_columns_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "aberfit/core/errors.h"
#include "file_options.h"

namespace aberfit::internal {
namespace {

std::optional<double> factor(const std::string& unit, Dimension dimension) {
  try {
    return unit_factor(unit, dimension);
  } catch (const UnitError&) {
    return std::nullopt;
  }
}

bool is_unit(const std::string& text) {
  return !text.empty() &&
         (factor(text, Dimension::kLength) || factor(text, Dimension::kAngle) || is_waves(text));
}

}  // namespace

double x_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit) {
  const std::optional<double> said = factor(unit, Dimension::kLength);
  return said ? agreed_factor(table.path, "x_unit", source.x_factor, *said, unit) : *source.x_factor;
}

double value_factor_beside(const MeasuredSource& source, const TextTable& table, const std::string& unit,
                           ProfileQuantity quantity) {
  const bool height = quantity == ProfileQuantity::kHeight;
  if (source.value_in_waves) {
    if (!height || (!unit.empty() && !is_waves(unit)))
      refuse_option(table.path, "value_unit", "waves", unit.empty() ? "slopes" : in_quotes(unit));
    return height_factor("waves", source, table, "option 'value_unit'");
  }
  if (height && is_waves(unit)) refuse_option(table.path, "value_unit", "a length", in_quotes(unit));
  const std::optional<double> said = factor(unit, height ? Dimension::kLength : Dimension::kAngle);
  // A length for an angle, or an angle for a length, is a contradiction as well.
  if (!said && factor(unit, height ? Dimension::kAngle : Dimension::kLength))
    refuse_option(table.path, "value_unit", height ? "a length" : "an angle", in_quotes(unit));
  return said ? agreed_factor(table.path, "value_unit", source.value_factor, *said, unit)
              : *source.value_factor;
}

ColumnName column_name(const TextTable& table, std::size_t column) {
  if (table.names.empty()) return {};
  std::string text(trimmed(table.names[column]));
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  // The unit is in the first bracket that holds one, otherwise in the first bracket: "SLOPE[urad][W/B4C]".
  ColumnName result;
  std::size_t word_end = std::string::npos;
  for (std::size_t open = text.find_first_of("(["); open != std::string::npos;
       open = text.find_first_of("([", open + 1)) {
    const std::size_t close = text.find(text[open] == '(' ? ')' : ']', open);
    if (close == std::string::npos) break;
    const std::string inside(trimmed(std::string_view(text).substr(open + 1, close - open - 1)));
    if (word_end != std::string::npos && !is_unit(inside)) continue;
    if (word_end == std::string::npos) word_end = open;
    result.unit = inside;
    if (is_unit(inside)) break;
  }
  if (word_end == std::string::npos) {
    const std::size_t sign = text.find_last_of("_/ ");
    if (sign != std::string::npos && sign > 0 && is_unit(text.substr(sign + 1))) {
      word_end = sign;
      result.unit = text.substr(sign + 1);
    }
  }
  result.word = lower_case(trimmed(std::string_view(text).substr(0, word_end)));
  return result;
}

std::optional<ProfileQuantity> quantity_of_word(const std::string& word) {
  const std::string lower = lower_case(word);
  const auto has = [&](const char* part) { return lower.find(part) != std::string::npos; };
  if (has("slope") || has("dz/dx") || has("angle") || has("tilt")) return ProfileQuantity::kSlope;
  if (has("height") || has("heigth") || has("sag") || has("figure") || has("opd") || has("wavefront") ||
      lower == "z" || lower == "h")
    return ProfileQuantity::kHeight;
  return std::nullopt;
}

double factor_or_fail(const std::string& unit, Dimension dimension, const TextTable& table,
                      const std::string& pointer, const std::string& more) {
  if (const std::optional<double> known = factor(unit, dimension)) return *known;
  throw InputError(table.path, pointer, unit.empty() ? "no unit" : "unit " + in_quotes(unit),
                   allowed_units(dimension) + more);
}

double height_factor(const std::string& unit, const MeasuredSource& source, const TextTable& table,
                     const std::string& pointer) {
  if (!is_waves(unit)) return factor_or_fail(unit, Dimension::kLength, table, pointer, ", waves");
  check_option(source, source.wavelength, "wavelength", true);
  const std::optional<double> wavelength = agreed_length(table.path, "wavelength", source.wavelength,
                                                         length_key(table, "wavelength"), kSameWavelength);
  if (!wavelength)
    throw MissingFact("wavelength", table.path, pointer, "heights in waves without a wavelength",
                      "the option 'wavelength' or a header line such as '# wavelength = 632.8 nm'");
  return *wavelength;
}

std::optional<bool> is_wavefront(const MeasuredSource& source, const TextTable& table) {
  const std::optional<std::string> of = key_value(table, "of");
  if (!of) return source.wavefront;
  for (const bool wavefront : {false, true})
    if (lower_case(*of) == (wavefront ? "wavefront" : "surface"))
      return agreed_wavefront(table.path, source.wavefront, wavefront);
  fail_at_line(table.path, table.keys.at("of").line, in_quotes(*of), "surface or wavefront");
}

std::optional<std::string> key_value(const TextTable& table, const std::string& key) {
  const auto found = table.keys.find(key);
  if (found == table.keys.end()) return std::nullopt;
  return found->second.value;
}

std::optional<double> length_key(const TextTable& table, const std::string& key) {
  const std::optional<std::string> text = key_value(table, key);
  if (!text) return std::nullopt;
  const long line = table.keys.at(key).line;
  double value = 0;
  try {
    value = parse_quantity(*text, Dimension::kLength);
  } catch (const UnitError&) {
    fail_at_line(table.path, line, in_quotes(*text), "a length with its unit such as '0.1 mm'");
  }
  if (!(value > 0)) fail_at_line(table.path, line, in_quotes(*text), "a length above zero");
  return value;
}

}  // namespace aberfit::internal
