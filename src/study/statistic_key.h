#pragma once
#include <string>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// ECMA regular expression of "ee<percent>": percent in (0, 100), at most four decimals, one spelling for
/// each value.
extern const char* const kEncircledEnergyName;

/// Kinds of keys of target.statistics.
const std::vector<KeyPattern>& statistic_keys();

/// Keys under which `requests` are written: names, and ring_fwhm@<ee> where several ring widths are asked
/// for.
std::vector<std::string> keys_of(const std::vector<StatisticRequest>& requests);

/// Whether values under this key are diameters: ee80_diameter, hew.
bool is_diameter(const std::string& key);

/// A request with the name (and ring) that the key says; of diameters that of the radius.
StatisticRequest request_of(const std::string& key);

}  // namespace aberfit::internal
