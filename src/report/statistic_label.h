#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit::internal {

/// Unique names of the targets: a repeated name gets "#2", "#3", ..., so that no statistic hides another in a
/// JSON object.
inline std::vector<std::string> unique_names(const std::vector<Target>& targets) {
  std::vector<std::string> names;
  names.reserve(targets.size());
  for (const Target& target : targets) {
    const std::string name = statistic_name(target.statistic);
    std::string unique = name;
    for (int k = 2; std::find(names.begin(), names.end(), unique) != names.end(); ++k)
      unique = name + "#" + std::to_string(k);
    names.push_back(unique);
  }
  return names;
}

}  // namespace aberfit::internal
