#include "aberfit/report/trace_report.h"

#include <fmt/format.h>

#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

Json to_json(const TraceReport& report, const Json& study) {
  Json json = json_document("trace", study);
  json["theory"] = report.theory;
  json["model"] = to_string(report.model);
  json["reason"] = report.reason;
  json["pupil_points"] = report.rays;
  json["lost_rays"] = report.lost_rays;
  json["terms"] = report.terms;
  for (const TracedStatistic& traced : report.statistics) {
    const std::string name = statistic_name(traced.statistic);
    json["statistics"][name] = json_number(traced.value);
    json["target"][name] = json_number(traced.target);
  }
  json["warnings"] = json_warnings(report.warnings);
  return json;
}

std::string summary_table(const TraceReport& report) {
  std::string text =
      fmt::format("{}\n\nmodel {}, {} {} ({} lost), {} terms\n\n  {:<28} {:>14} {:>14} {:>9}\n", report.title,
                  to_string(report.model), report.rays, report.model == FocusModel::kWaves ? "cells" : "rays",
                  report.lost_rays, report.terms, "statistic [SI]", "surface", "target", "diff");
  for (const TracedStatistic& traced : report.statistics)
    text += fmt::format("  {:<28} {:>14.6g} {:>14.6g} {:>8.2f}%\n", statistic_name(traced.statistic),
                        traced.value, traced.target, 100 * (traced.value / traced.target - 1));
  return text + warning_lines(report.warnings);
}

}  // namespace aberfit
