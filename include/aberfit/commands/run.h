#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/method/run_context.h"
#include "aberfit/report/result.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// Threads and progress as the method takes them.
RunContext context_of(const RunOptions& options);

/// target -> fit -> verdict (the main path). For a study without target.map.
ResultDocument run_fit(const Study& study, const RunOptions& options);
/// The study of a result: `study` with what the fit has chosen where it leaves that open.
nlohmann::ordered_json resolved(const Study& study, const FitOutcome& outcome);
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
