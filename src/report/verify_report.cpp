#include "aberfit/report/verify_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "aberfit/core/text.h"
#include "json_number.h"
#include "paragraph.h"
#include "scene_facts_json.h"

namespace aberfit {
using namespace internal;

namespace {

std::string convention_word(Convention convention) {
  return convention == Convention::kPaper ? "paper" : "physical";
}

// The worst statistic of a comparison that is not equivalent: nearest to its margin or beyond it.
std::string worst(const std::vector<EquivalenceMetric>& metrics) {
  const EquivalenceMetric* found = nullptr;
  const auto reach = [](const EquivalenceMetric& m) {
    return std::max(std::abs(m.interval[0]), std::abs(m.interval[1]));
  };
  for (const EquivalenceMetric& m : metrics)
    if (m.verdict != Verdict::kEquivalent && (!found || reach(m) > reach(*found))) found = &m;
  return found ? fmt::format(" ({} {:+.2f} %)", found->name, 100 * found->relative_difference) : "";
}

std::string light_word(const VerifyReport& report) {
  return report.light_obstacle.empty() ? upper_case(to_string(report.light_verdict)) + worst(report.light)
                                       : "not computed";
}

// Verdict of the theory that decides, and what the other says.
std::string headline(const VerifyReport& report) {
  const std::string rays = upper_case(to_string(report.rays_verdict)) + worst(report.metrics);
  const std::string first =
      report.rays_decide ? rays + " in geometric rays" : light_word(report) + " in light";
  const std::string second =
      report.rays_decide ? "in light " + light_word(report) : "in geometric rays " + rays;
  return fmt::format("{}; {}", first, second);
}

std::string judged_line(const VerifyReport& report) {
  const double level = 100 * report.margin;
  return report.draws > 0
             ? fmt::format(
                   "Judged: the mean light of {} drawn surfaces, at a margin of {:.3g} %, convention {}",
                   report.draws, level, convention_word(report.convention))
             : fmt::format("Judged: the given surface by {} rays, at a margin of {:.3g} %, convention {}",
                           report.rays, level, convention_word(report.convention));
}

std::string metric_rows(const std::vector<EquivalenceMetric>& metrics, const std::vector<double>* theory) {
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.5g}", value) : "-"; };
  std::string text;
  for (std::size_t k = 0; k < metrics.size(); ++k) {
    const EquivalenceMetric& m = metrics[k];
    text += fmt::format(
        "  {:<24} {:>11} {:>11} {:>11} {:>8.2f}% {:>15}  {}\n", m.name, theory ? number(theory->at(k)) : "",
        number(m.target), number(m.model), 100 * m.relative_difference,
        fmt::format("{:+.2f} {:+.2f}", 100 * m.interval[0], 100 * m.interval[1]), to_string(m.verdict));
  }
  return text;
}

std::string heading(const char* theory, const char* target, const char* model) {
  return fmt::format("  {:<24} {:>11} {:>11} {:>11} {:>9} {:>15}  {}\n", "statistic [SI]", theory, target,
                     model, "diff", "interval [%]", "verdict");
}

// What is printed, with its unit where it is a number or begins with one: a formula has none.
std::string printed_cell(const PublishedComparison& row) {
  std::string text = row.printed_text.empty() ? fmt::format("{:.6g}", row.printed) : row.printed_text;
  const bool of_numbers =
      std::isdigit(static_cast<unsigned char>(text.front())) && text.find('_') == std::string::npos;
  if (!row.unit.empty() && (std::isfinite(row.printed) || of_numbers)) text += " " + row.unit;
  return row.derived ? text + " (derived)" : text;
}

constexpr std::size_t kLabelColumns = 46, kPrintedColumns = 18;

// Label, printed, ours, verdict; on two lines where the first two are too long for one.
std::string published_line(const std::string& label, const std::string& printed, const std::string& ours,
                           const std::string& verdict) {
  const bool fits = label.size() <= kLabelColumns && printed.size() <= kPrintedColumns;
  const std::string left =
      fits ? fmt::format("{:<{}} {:>{}}", label, kLabelColumns, printed, kPrintedColumns)
           : fmt::format("{}\n  {:>{}}", label, printed, kLabelColumns + 1 + kPrintedColumns);
  return fmt::format("  {}  {:>15}  {}\n", left, ours, verdict);
}

std::string published_row(const PublishedComparison& row) {
  const std::string ours = std::isfinite(row.ours)
                               ? fmt::format("{:.5g}{}{}", row.ours, row.unit.empty() ? "" : " ", row.unit)
                           : row.picture.empty() ? "-"
                                                 : row.picture;
  std::string text = published_line(row.label, printed_cell(row), ours, row.verdict);
  if (!row.reading.empty()) text += "      " + wrapped(row.reading, kColumns - 6, 6) + "\n";
  return text;
}

std::string published_table(const std::vector<PublishedComparison>& rows) {
  if (rows.empty()) return "";
  std::map<std::string, int> count;
  for (const PublishedComparison& row : rows) ++count[row.verdict];
  std::string tally;
  for (const auto& [word, number] : count)
    tally +=
        fmt::format("{}{} {}", tally.empty() ? "" : ", ", number, word.empty() ? "without verdict" : word);
  std::string text = fmt::format("\nPublished numbers: {}\n", wrapped(tally, kColumns - 19, 19));
  std::string section;
  for (const PublishedComparison& row : rows) {
    if (&row == &rows.front() || row.section != section) {
      section = row.section;
      text += "\n" + published_line(section.empty() ? "published" : section, "printed", "ours", "verdict");
    }
    text += published_row(row);
  }
  return text;
}

Json metric_json(const EquivalenceMetric& m, const char* target, const char* model) {
  return {{target, json_number(m.target)},
          {model, json_number(m.model)},
          {"relative_difference", json_number(m.relative_difference)},
          {"standard_error", json_number(m.standard_error)},
          {"interval", {json_number(m.interval[0]), json_number(m.interval[1])}},
          {"verdict", to_string(m.verdict)}};
}

Json published_json(const PublishedComparison& row) {
  return {{"id", row.id},
          {"section", row.section},
          {"label", row.label},
          {"unit", row.unit},
          {"printed", json_number(row.printed)},
          {"printed_text", row.printed_text},
          {"derived", row.derived},
          {"ours", json_number(row.ours)},
          {"from", row.from},
          {"within", json_number(row.within)},
          {"verdict", row.verdict},
          {"reading", row.reading},
          {"picture", row.picture}};
}

}  // namespace

Json to_json(const VerifyReport& report, const Json& study) {
  Json json = json_document("verify", study);
  json["headline"] = headline(report);
  json["convention"] = convention_word(report.convention);
  json["verdict"] = to_string(report.verdict);
  json["decided_by"] = report.rays_decide ? "rays" : "light";
  json["draws"] = report.draws;
  json["margin"] = report.margin;
  json["scene"] = scene_json(report.scene);
  for (std::size_t k = 0; k < report.metrics.size(); ++k) {
    Json row = {{"theory", json_number(report.theory.at(k))}};
    row.update(metric_json(report.metrics[k], "harvey_shack", "aberration_terms"));
    json["statistics"][report.metrics[k].name] = row;
  }
  json["light"] = {{"verdict", to_string(report.light_verdict)}, {"draws", report.light_draws}};
  if (!report.light_obstacle.empty()) json["light"]["obstacle"] = report.light_obstacle;
  for (const EquivalenceMetric& m : report.light)
    json["light"]["statistics"][m.name] = metric_json(m, "ghs", "waves");
  for (const PublishedComparison& row : report.published) json["published"].push_back(published_json(row));
  for (const auto& [name, value] : report.quantities) json["quantities"][name] = json_number(value);
  json["warnings"] = json_warnings(report.warnings);
  return json;
}

std::string summary_table(const VerifyReport& report) {
  std::string text = fmt::format("{}\n\n{}\n", wrapped(headline(report), kColumns, 2), judged_line(report));
  if (!report.title.empty()) text = report.title + "\n\n" + text;
  text += "\nBy rays: Harvey-Shack (perturbed rays) and aberration terms (traced)\n\n";
  text += heading("theory", "Harvey-Shack", "terms") + metric_rows(report.metrics, &report.theory);
  if (!report.light.empty()) {
    const std::string of_what = fmt::format(
        "In light: generalised Harvey-Shack{} and the diffraction of the terms{}; EE differs by shares",
        report.convention == Convention::kPaper ? " of half the heights" : "",
        report.light_draws > 0 ? fmt::format(", {} draws", report.light_draws) : "");
    text += "\n" + wrapped(of_what, kColumns, 2) + "\n\n";
    text += heading("", "GHS", "waves") + metric_rows(report.light, nullptr);
  }
  text += fmt::format("\n  verdict: {} at a margin of {:.3g} %\n", to_string(report.verdict),
                      100 * report.margin);
  return text + published_table(report.published) + warning_lines(report.warnings);
}

}  // namespace aberfit
