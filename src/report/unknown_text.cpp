#include "unknown_text.h"

#include <fmt/format.h>

namespace aberfit::internal {

std::string unit_suffix(Dimension dimension) {
  switch (dimension) {
    case Dimension::kLength:
      return "_m";
    case Dimension::kSpatialFrequency:
      return "_per_m";
    case Dimension::kPsd2d:
      return "_m4";
    default:
      return "";
  }
}

std::string name_of(const SolveUnknown& unknown) {
  const std::string name = unknown.pointer.substr(unknown.pointer.rfind('/') + 1);
  return unknown.part.empty() ? name : name + " of " + unknown.part;
}

std::string column_of(const SolveUnknown& unknown) {
  const std::string head = "/roughness/psd/";
  return (unknown.pointer.starts_with(head) ? unknown.pointer.substr(head.size()) : unknown.pointer) +
         unit_suffix(unknown.dimension);
}

std::string six_digits(double value, Dimension dimension) {
  const std::string short_text = format_quantity(value, dimension);
  const std::size_t unit = short_text.find(' ');
  if (unit == std::string::npos || value == 0) return fmt::format("{:.6g}", value);
  const std::string name = short_text.substr(unit + 1);
  return fmt::format("{:.6g} {}", value / unit_factor(name, dimension), name);
}

}  // namespace aberfit::internal
