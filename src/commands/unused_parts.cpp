#include "unused_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace aberfit::internal {

Warnings unused_parts(const Study& study, const std::string& remedy) {
  if (!study.solve || !study.solve->with) return {};
  const ContributorsSpec& with = *study.solve->with;
  std::vector<std::string> parts;
  if (with.atmosphere) parts.emplace_back("atmosphere");
  if (with.jitter > 0) parts.emplace_back("jitter");
  if (!with.surfaces.empty()) parts.emplace_back("surfaces");
  if (parts.empty()) return {};
  return {{"contributors-not-used",
           fmt::format(
               "solve.with ({}) is not used here, because these results are of the mirror alone; {} uses it",
               fmt::join(parts, ", "), remedy)}};
}

}  // namespace aberfit::internal
