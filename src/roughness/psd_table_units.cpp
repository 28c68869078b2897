#include "psd_table_units.h"

#include <cctype>
#include <vector>

#include "aberfit/core/text.h"

namespace aberfit::internal {
namespace {

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Fields of a row of names: separators inside brackets separate nothing, and a unit in brackets belongs to
// the name before it.
std::vector<std::string> header_fields(std::string_view row) {
  char delimiter = ' ';
  for (const char candidate : {';', '\t', ','}) {
    int depth = 0;
    for (const char c : row) {
      depth += (c == '(' || c == '[' ? 1 : 0) - (c == ')' || c == ']' ? 1 : 0);
      if (c == candidate && depth == 0 && delimiter == ' ') delimiter = candidate;
    }
  }
  std::vector<std::string> fields(1);
  int depth = 0;
  for (std::size_t at = 0; at < row.size(); ++at) {
    const char c = row[at];
    const bool opens = c == '(' || c == '[';
    if (opens && depth == 0 && delimiter == ' ' && fields.size() > 1 && fields.back().empty())
      fields.pop_back();
    depth += (opens ? 1 : 0) - (c == ')' || c == ']' ? 1 : 0);
    if (depth <= 0 && c == delimiter) {
      if (delimiter != ' ' || !fields.back().empty()) fields.emplace_back();
    } else if (c != '"') {
      fields.back() += c;
    }
  }
  return fields;
}

// "nm2_mm2", "per_mm", "mm-1" with the signs that a unit has: "nm^2 mm^2", "/mm", "mm^-1".
std::string with_signs(std::string_view text) {
  std::string unit;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : ' ';
    if (text.substr(i).starts_with("\u00b7") || text.substr(i).starts_with("\u22c5")) {
      unit += ' ';
      i += text.substr(i).starts_with("\u00b7") ? 1 : 2;
    } else if (text.substr(i).starts_with("per_") || text.substr(i).starts_with("per ")) {
      unit += '/';
      i += 3;
    } else {
      unit += c == '_' ? ' ' : c;
      if (is_letter(c) && (is_digit(next) || (next == '-' && i + 2 < text.size() && is_digit(text[i + 2]))))
        unit += '^';
    }
  }
  return std::string(trimmed(unit));
}

// The unit in a name, where one of `dimensions` is.
std::string unit_in(const std::string& name, const std::vector<Dimension>& dimensions) {
  std::vector<std::string> candidates;
  for (std::size_t open = name.find_first_of("[("); open != std::string::npos;
       open = name.find_first_of("[(", open + 1))
    if (const std::size_t close = name.rfind(name[open] == '[' ? ']' : ')');
        close != std::string::npos && close > open)
      candidates.push_back(name.substr(open + 1, close - open - 1));
  candidates.push_back(name);
  for (std::size_t sign = name.find_first_of("_/ "); sign != std::string::npos;
       sign = name.find_first_of("_/ ", sign + 1))
    candidates.push_back(name.substr(sign + 1));
  for (const std::string& candidate : candidates)
    for (const Dimension dimension : dimensions)
      if (const std::string unit = with_signs(candidate); factor_of(unit, dimension)) return unit;
  return {};
}

}  // namespace

std::optional<double> factor_of(const std::string& unit, Dimension dimension) {
  if (unit.empty()) return std::nullopt;
  try {
    return unit_factor(unit, dimension);
  } catch (const UnitError&) {
    return std::nullopt;
  }
}

HeaderUnits units_of_header(std::string_view row) {
  const std::vector<std::string> fields = header_fields(trimmed(row));
  if (fields.size() < 2) return {};
  return {unit_in(fields[0], {Dimension::kSpatialFrequency}),
          unit_in(fields[1], {Dimension::kPsd2d, Dimension::kPsd1d})};
}

}  // namespace aberfit::internal
