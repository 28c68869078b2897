#include "shown_statistic.h"

#include <fmt/format.h>

#include <cmath>

#include "paragraph.h"
#include "statistic_label.h"

namespace aberfit::internal {

ShownStatistics::ShownStatistics(const std::vector<Target>& targets) {
  const std::vector<std::string> names = unique_names(targets);
  for (std::size_t k = 0; k < names.size(); ++k)
    if (!targets[k].asked.as_it_is()) asked_.emplace(names[k], targets[k].asked);
}

std::string ShownStatistics::name(const std::string& name) const {
  const auto asked = asked_.find(name);
  if (asked == asked_.end() || asked->second.name.empty()) return name_without_unit(name);
  const std::size_t plane = name.find('@');
  return asked->second.name + (plane == std::string::npos ? "" : name.substr(plane));
}

std::string ShownStatistics::value(const std::string& name, double value) const {
  const auto asked = asked_.find(name);
  if (asked == asked_.end()) return four_digits(value, dimension_of_name(name));
  const AskedAs& as = asked->second;
  if (as.unit.empty()) return four_digits(value * as.per_si, dimension_of_name(name));
  return std::isfinite(value) ? fmt::format("{:#.4g} {}", value * as.per_si, as.unit) : "-";
}

}  // namespace aberfit::internal
