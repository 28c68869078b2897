#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/report/result.h"
#include "aberfit/study/run_options.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// target -> fit -> verdict (the main path).
ResultDocument run_fit(const Study& study, const RunOptions& options);
/// Harvey-Shack branch, aberration-term branch and, where asked, published numbers side by side.
nlohmann::ordered_json run_verify(const Study& study, const RunOptions& options, std::string* table);
/// Forward statistics only.
nlohmann::ordered_json run_trace(const Study& study, const RunOptions& options, std::string* table);
/// The measurement of a study (the first, where a sum has several). Throws InputError when it has none.
const MeasuredPsd& measured_psd_of(const Study& study);
/// What read_study or read_measured made of a measurement, reported: files, pictures, the table,
/// result.json's content.
nlohmann::ordered_json run_psd(const MeasuredPsd& measured, const std::string& title,
                               const RunOptions& options, std::string* table);
/// The resolved study, the numbers of its scene, the model it needs and why, predicted cost (with a chart of
/// the same study within a factor 1.5, without within 3 for the studies of fits/). Computes no fit. Throws
/// InputError for a chart_file that is no chart.
nlohmann::ordered_json run_check(const Study& study, const RunOptions& options, std::string* table);

}  // namespace aberfit
