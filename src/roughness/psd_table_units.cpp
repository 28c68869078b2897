#include "psd_table_units.h"

#include <vector>

#include "aberfit/core/text.h"

namespace aberfit::internal {
namespace {

// Fields of a row of names. Separators inside brackets do not count; a unit belongs to the name before it.
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

std::string unit_in(const std::string& name, const std::vector<Dimension>& dimensions) {
  for (const Dimension dimension : dimensions)
    if (const std::string unit = unit_of_column(name, dimension); !unit.empty()) return unit;
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
