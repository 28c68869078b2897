#include "aberfit/report/verify_report.h"

#include <fmt/format.h>

#include <cmath>

#include "json_number.h"
#include "paragraph.h"
#include "scene_facts_json.h"

namespace aberfit {
using namespace internal;

namespace {

using Json = nlohmann::ordered_json;

std::string convention_word(Convention convention) {
  return convention == Convention::kPaper ? "paper" : "physical";
}

std::string published_row(const PublishedComparison& row) {
  const std::string printed = fmt::format("{:.6g} {}", row.printed, row.unit);
  const std::string shown = std::isfinite(row.ours) ? fmt::format("{:.5g} {}", row.ours, row.unit) : "-";
  return fmt::format("  {:<44} {:>14} {:>16}  {}\n", row.label, printed, shown, wrapped(row.reading, 64, 80));
}

}  // namespace

Json to_json(const VerifyReport& report, const Json& study) {
  Json json = {{"aberfit", 1},
               {"kind", "verify"},
               {"study", study},
               {"convention", convention_word(report.convention)},
               {"verdict", to_string(report.verdict)},
               {"scene", scene_json(report.scene)}};
  for (std::size_t k = 0; k < report.metrics.size(); ++k) {
    const EquivalenceMetric& m = report.metrics[k];
    json["statistics"][m.name] = {{"theory", json_number(report.theory.at(k))},
                                  {"harvey_shack", json_number(m.target)},
                                  {"aberration_terms", json_number(m.model)},
                                  {"relative_difference", json_number(m.relative_difference)},
                                  {"interval", {json_number(m.interval[0]), json_number(m.interval[1])}},
                                  {"verdict", to_string(m.verdict)}};
  }
  for (const PublishedComparison& row : report.published)
    json["published"].push_back({{"label", row.label},
                                 {"unit", row.unit},
                                 {"printed", row.printed},
                                 {"ours", json_number(row.ours)},
                                 {"from", row.from},
                                 {"reading", row.reading}});
  for (const auto& [name, value] : report.quantities) json["quantities"][name] = json_number(value);
  json["warnings"] = json_warnings(report.warnings);
  return json;
}

std::string summary_table(const VerifyReport& report) {
  std::string text = fmt::format(
      "{}\n\nBoth branches, {} rays, convention {}; realisation scatter {:.1f} % (draws of this "
      "roughness)\n\n",
      report.title, report.rays, convention_word(report.convention), 100 * report.spread);
  text += fmt::format("  {:<28} {:>13} {:>13} {:>13} {:>9}  {}\n", "statistic [SI]", "theory", "Harvey-Shack",
                      "terms", "diff", "verdict");
  for (std::size_t k = 0; k < report.metrics.size(); ++k) {
    const EquivalenceMetric& m = report.metrics[k];
    text += fmt::format("  {:<28} {:>13.6g} {:>13.6g} {:>13.6g} {:>8.2f}%  {}\n", m.name, report.theory.at(k),
                        m.target, m.model, 100 * m.relative_difference, to_string(m.verdict));
  }
  text += fmt::format("\n  verdict: {} at a margin of {:.3g} %\n", to_string(report.verdict),
                      100 * report.margin);
  if (!report.published.empty())
    text += fmt::format("\nPublished numbers\n\n  {:<44} {:>14} {:>16}  {}\n", "published", "printed", "ours",
                        "reading");
  for (const PublishedComparison& row : report.published) text += published_row(row);
  return text + warning_lines(report.warnings);
}

}  // namespace aberfit
