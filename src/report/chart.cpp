#include "aberfit/report/chart.h"

#include <fmt/format.h>

#include <iterator>

#include "aberfit/core/units.h"
#include "json_number.h"

namespace aberfit {
using namespace internal;

namespace {

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "\"";
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

Json row_json(const ChartRow& row) {
  return {{"family", row.family},
          {"method", row.method},
          {"parameter", row.parameter},
          {"value", json_number(row.value)},
          {"unit", row.unit},
          {"rays", row.rays},
          {"terms", row.terms},
          {"statistics", row.statistics},
          {"error", json_number(row.error)},
          {"error_rms", json_number(row.error_rms)},
          {"error_of_reference", json_number(row.error_of_reference)},
          {"reference", row.reference},
          {"seconds", json_number(row.seconds)},
          {"seconds_low", json_number(row.seconds_low)},
          {"seconds_high", json_number(row.seconds_high)},
          {"repeats", row.repeats},
          {"on_frontier", row.on_frontier},
          {"is_default", row.is_default},
          {"is_cheapest_within_tolerance", row.is_cheapest_within_tolerance},
          {"note", row.note}};
}

}  // namespace

std::string chart_csv(const Chart& chart) {
  std::string text =
      "family,method,parameter,value,unit,rays,terms,statistics,error,error_rms,error_of_reference,tolerance,"
      "reference,seconds,seconds_low,seconds_high,repeats,on_frontier,is_default,is_cheapest_within_"
      "tolerance,error_of,timed,note\n";
  for (const ChartFamily& family : chart.families)
    for (const ChartRow& row : family.rows)
      fmt::format_to(std::back_inserter(text),
                     "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:d},{:d},{:d},{},{},{}\n",
                     csv_text(row.family), csv_text(row.method), csv_text(row.parameter),
                     csv_number(row.value), csv_text(row.unit), row.rays, row.terms, row.statistics,
                     csv_number(row.error), csv_number(row.error_rms), csv_number(row.error_of_reference),
                     csv_number(family.tolerance), csv_text(row.reference), csv_number(row.seconds),
                     csv_number(row.seconds_low), csv_number(row.seconds_high), row.repeats, row.on_frontier,
                     row.is_default, row.is_cheapest_within_tolerance, csv_text(family.error_of),
                     csv_text(family.timed), csv_text(row.note));
  return text;
}

Json to_json(const Chart& chart, const Json& study, const Provenance& provenance) {
  Json families = Json::array(), rows = Json::array();
  for (const ChartFamily& family : chart.families) {
    families.push_back({{"name", family.name},
                        {"title", family.title},
                        {"error_of", family.error_of},
                        {"timed", family.timed},
                        {"tolerance", json_number(family.tolerance)},
                        {"tolerance_of", family.tolerance_of},
                        {"rows", family.rows.size()},
                        {"remark", family.remark},
                        {"skipped", family.skipped.empty() ? Json(nullptr) : Json(family.skipped)}});
    for (const ChartRow& row : family.rows) rows.push_back(row_json(row));
  }
  return {{"aberfit", 1},
          {"kind", "chart"},
          {"study", study},
          {"machine", {{"threads", chart.threads}, {"instruction_set", chart.instruction_set}}},
          {"families", families},
          {"rows", rows},
          {"budget_seconds", json_number(chart.budget_seconds)},
          {"seconds", json_number(chart.seconds)},
          {"warnings", json_warnings(chart.warnings)},
          {"provenance", to_json(provenance)}};
}

}  // namespace aberfit
