#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// Speed against accuracy on the study's own scene: every method and setting, its error against a reference
/// and its time; writes chart.csv, chart.json, summary.txt and pictures. Which settings are measured, on
/// how many rays and against how fine a reference depends on options.chart_seconds and the machine; every row
/// says it. Throws InputError for a study of a map, which has no statistics to be wrong about.
nlohmann::ordered_json run_chart(const Task& task, const RunOptions& options, std::string* table);

}  // namespace aberfit
