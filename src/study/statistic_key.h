#pragma once
#include <string>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// ECMA regular expression of "ee<percent>": percent in (0, 100) with at most four decimals. Each value has
/// one spelling.
extern const char* const kEncircledEnergyName;

/// Kinds of keys of target.statistics.
const std::vector<KeyPattern>& statistic_keys();

/// Keys under which `requests` are written: their names, or ring_fwhm@<ee> if there are several ring widths.
std::vector<std::string> keys_of(const std::vector<StatisticRequest>& requests);

/// Returns whether values under this key are diameters: ee80_diameter, hew.
bool is_diameter(const std::string& key);

/// A request with the name (and ring) that the key gives. For a diameter it has the name of the radius.
StatisticRequest request_of(const std::string& key);

}  // namespace aberfit::internal
