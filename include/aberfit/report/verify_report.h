#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/method/verify.h"

namespace aberfit {

/// result.json of `aberfit verify`: convention, verdict, scene, statistics of theory and both branches,
/// published numbers where there are any, quantities, warnings. study: the resolved study. SI numbers, unit
/// in the key; what does not exist is null.
nlohmann::ordered_json to_json(const VerifyReport& report, const nlohmann::ordered_json& study);

/// The table people read on the terminal.
std::string summary_table(const VerifyReport& report);

}  // namespace aberfit
