#pragma once
#include <map>
#include <string>
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit::internal {

/// Statistics for people: with the name and unit of the study, else with their own name and a suitable unit.
class ShownStatistics {
 public:
  explicit ShownStatistics(const std::vector<Target>& targets);

  /// name: as in the results, "ee80_radius_m@-1mm".
  std::string name(const std::string& name) const;
  /// Four digits with unit; "-" if `value`, in the SI unit of the name, is not finite.
  std::string value(const std::string& name, double value) const;

 private:
  std::map<std::string, AskedAs> asked_;
};

}  // namespace aberfit::internal
