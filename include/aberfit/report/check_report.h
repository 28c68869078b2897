#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/chart/check.h"

namespace aberfit {

/// What `aberfit check --json` prints: mirror, scene with both verdicts (absent without roughness), terms,
/// the cost of one iteration (its seconds null where none was made), warnings, the paper's table where asked
/// for. study: the resolved study. SI numbers, unit in the key; what does not exist is null.
nlohmann::ordered_json to_json(const CheckReport& report, const nlohmann::ordered_json& study);
/// The same of a map: its points and the number of terms.
nlohmann::ordered_json to_json(const MapCheckReport& report, const nlohmann::ordered_json& study);

/// The table people read on the terminal: a label and a value per line, warnings, the paper's table.
std::string summary_table(const CheckReport& report);
std::string summary_table(const MapCheckReport& report);

}  // namespace aberfit
