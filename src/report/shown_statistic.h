#pragma once
#include <map>
#include <string>
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit::internal {

/// Statistics as people read them: by the name and in the unit that the study asked for them in, else by
/// their own name and in the unit that suits the value.
class ShownStatistics {
 public:
  explicit ShownStatistics(const std::vector<Target>& targets);

  /// name: as in results, "ee80_radius_m@-1mm".
  std::string name(const std::string& name) const;
  /// Four digits with unit; value in the SI unit of the name; "-" where it is not finite.
  std::string value(const std::string& name, double value) const;

 private:
  std::map<std::string, AskedAs> asked_;
};

}  // namespace aberfit::internal
