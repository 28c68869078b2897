#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/chart/cost_model.h"

namespace aberfit {

/// `rates` of a chart.json.
nlohmann::ordered_json to_json(const FitRates& rates);
/// The rates of a chart.json or of the folder it lies in; `same_study`: whether it is of this resolved study.
/// Throws InputError for a file that is no chart.
FitRates read_rates(const std::string& file_or_folder, const nlohmann::ordered_json& study, bool* same_study);

}  // namespace aberfit
