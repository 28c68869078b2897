#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/text.h"
#include "aberfit/report/chart.h"
#include "aberfit/report/documents.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 1e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  if (seconds < 1) return fmt::format("{:.3g} ms", 1e3 * seconds);
  return fmt::format("{:.3g} s", seconds);
}

std::string error_text(double error) {
  if (!std::isfinite(error)) return "-";
  if (error == 0) return "0";
  return error >= 1e-4 ? fmt::format("{:.3g} %", 100 * error) : fmt::format("{:.1e}", error);
}

const ChartRow* best_of(const ChartFamily& family) {
  const ChartRow* best = nullptr;
  for (const ChartRow& row : family.rows)
    if (std::isfinite(row.error) && (!best || row.error < best->error)) best = &row;
  return best;
}

const ChartRow* find(const ChartFamily& family, bool ChartRow::*flag) {
  const auto at =
      std::find_if(family.rows.begin(), family.rows.end(), [flag](const ChartRow& row) { return row.*flag; });
  return at == family.rows.end() ? nullptr : &*at;
}

// Conclusion from the rows of a family.
std::string said_by(const ChartFamily& family, const ChartRow* today, const ChartRow* cheapest) {
  if (!cheapest) {
    const ChartRow* best = best_of(family);
    return best && best->error_of_reference > family.tolerance
               ? "The reference is less exact than the tolerance; a larger --seconds helps."
               : "No setting that was measured meets the tolerance.";
  }
  if (cheapest == today) return "Nothing cheaper meets the tolerance.";
  if (!today) return "";
  return today->error <= family.tolerance
             ? fmt::format("The study's setting takes {:.3g} times as long as the cheapest.",
                           today->seconds / cheapest->seconds)
             : "The study's setting does not meet the tolerance.";
}

void add_family(Page* page, const ChartFamily& family) {
  if (family.rows.empty()) return page->say("", family.title + ": " + family.skipped);
  const ChartRow* today = find(family, &ChartRow::is_default);
  const ChartRow* cheapest = find(family, &ChartRow::is_cheapest_within_tolerance);
  Page::Table table{fmt::format("{}: {}; tolerance {} ({}); time of {}", family.title, family.error_of,
                                error_text(family.tolerance), family.tolerance_of, family.timed),
                    {"", "setting", "error", "time"},
                    "llrr"};
  const auto add = [&](const char* what, const ChartRow* row) {
    if (row) table.add({what, setting_text(*row), error_text(row->error), seconds_text(row->seconds)});
  };
  add("today", today);
  if (cheapest != today) add("cheapest", cheapest);
  if (const ChartRow* best = cheapest ? nullptr : best_of(family); best != today) add("best", best);
  table.note = said_by(family, today, cheapest);
  if (!family.remark.empty()) table.note += (table.note.empty() ? "" : " ") + family.remark;
  page->parts.push_back(std::move(table));
}

// How often the automatic setting is accurate enough, and where it could be faster.
std::string headline_of(const Chart& chart) {
  int compared = 0, met = 0;
  std::string faster;
  double most = 1;
  for (const ChartFamily& family : chart.families) {
    const ChartRow* today = find(family, &ChartRow::is_default);
    const ChartRow* cheapest = find(family, &ChartRow::is_cheapest_within_tolerance);
    if (!today) continue;
    ++compared;
    met += today->error <= family.tolerance;
    if (!cheapest || !(today->seconds > most * cheapest->seconds)) continue;
    most = today->seconds / cheapest->seconds;
    faster =
        fmt::format("; in \"{}\" another setting that meets it is {:.2g} times faster", family.title, most);
  }
  if (compared == 0) return "";
  return fmt::format("The automatic setting meets its tolerance in {} of {}{}", met,
                     plural(compared, "comparison"), faster);
}

}  // namespace

std::string setting_text(const ChartRow& row) {
  if (!std::isfinite(row.value)) return row.method;
  const std::string value =
      row.value == std::floor(row.value) ? grouped(row.value) : fmt::format("{:.3g}", row.value);
  return fmt::format("{}, {} {}{}", row.method, row.parameter, value, row.unit == "1" ? "" : " " + row.unit);
}

Page page_of(const Chart& chart) {
  Page page;
  page.title = chart.title;
  page.headline = headline_of(chart);
  page.say("Machine", fmt::format("{}, kernels for {}; {:.1f} s of {:.3g} s", plural(chart.threads, "thread"),
                                  chart.instruction_set, chart.seconds, chart.budget_seconds));
  page.answers.push_back({"How certain",
                          "Times are medians on this machine. Each error is that against the family's "
                          "reference; each row gives the reference's own error."});
  page.answers.push_back({"What it rests on", "It holds for this scene; another scene has another chart."});
  page.answers.push_back(
      {"What would change it", "A larger --seconds gives finer references and more settings."});
  page.answers.push_back({"How to read the tables",
                          "\"today\" is the setting of the study, or the automatic one; \"cheapest\" is the "
                          "fastest setting within the tolerance."});
  page.answers.push_back({"What to do next",
                          "Where the cheapest setting is much faster, give it in the study; else leave the "
                          "settings out. chart.csv has every setting that was measured."});
  for (const ChartFamily& family : chart.families) add_family(&page, family);
  page.warnings = chart.warnings;
  return page;
}

}  // namespace aberfit
