#include <fmt/format.h>

#include <algorithm>

#include "aberfit/core/text.h"
#include "aberfit/report/chart.h"
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

const ChartRow* find(const ChartFamily& family, bool ChartRow::*flag) {
  const auto at =
      std::find_if(family.rows.begin(), family.rows.end(), [flag](const ChartRow& row) { return row.*flag; });
  return at == family.rows.end() ? nullptr : &*at;
}

std::string table_line(const std::string& what, const ChartRow& row) {
  return fmt::format("    {:<10} {:<40} error {:>9}   {:>9}\n", what, setting_text(row),
                     error_text(row.error), seconds_text(row.seconds));
}

std::string family_text(const ChartFamily& family) {
  std::string text = "\n" + family.title + "\n";
  if (family.rows.empty()) return text + paragraph("    ", family.skipped, 4);
  text += paragraph("    ",
                    fmt::format("{}; against {} ({}); time of {}", family.error_of,
                                error_text(family.tolerance), family.tolerance_of, family.timed),
                    4);
  const ChartRow* today = find(family, &ChartRow::is_default);
  const ChartRow* cheapest = find(family, &ChartRow::is_cheapest_within_tolerance);
  if (today) text += table_line("today", *today);
  if (cheapest && cheapest != today) text += table_line("cheapest", *cheapest);
  if (!cheapest) {
    const ChartRow* best = nullptr;
    for (const ChartRow& row : family.rows)
      if (std::isfinite(row.error) && (!best || row.error < best->error)) best = &row;
    if (best && best != today) text += table_line("best", *best);
    const bool vague = best && best->error_of_reference > family.tolerance;
    text += vague ? "    The reference is not known to the tolerance; more --seconds help.\n"
                  : "    No setting that was measured meets the tolerance.\n";
  } else if (cheapest == today) {
    text += "    Nothing cheaper meets the tolerance.\n";
  } else if (today) {
    text += today->error <= family.tolerance
                ? fmt::format("    Today's setting costs {:.3g} times as much.\n",
                              today->seconds / cheapest->seconds)
                : "    Today's setting does not meet the tolerance.\n";
  }
  if (!family.remark.empty()) text += paragraph("    ", family.remark, 4);
  return text;
}

}  // namespace

std::string setting_text(const ChartRow& row) {
  if (!std::isfinite(row.value)) return row.method;
  const std::string value =
      row.value == std::floor(row.value) ? grouped(row.value) : fmt::format("{:.3g}", row.value);
  return fmt::format("{}, {} {}{}", row.method, row.parameter, value, row.unit == "1" ? "" : " " + row.unit);
}

std::string summary_table(const Chart& chart) {
  std::string text = "Speed against accuracy" + (chart.title.empty() ? "" : ": " + chart.title) + "\n";
  text += fmt::format("{}, kernels for {}; {:.1f} s of {:.3g} s\n", plural(chart.threads, "thread"),
                      chart.instruction_set, chart.seconds, chart.budget_seconds);
  for (const ChartFamily& family : chart.families) text += family_text(family);
  for (const Warning& warning : chart.warnings)
    text += fmt::format("\n{}", paragraph("WARNING", fmt::format("[{}] {}", warning.code, warning.message)));
  return text;
}

}  // namespace aberfit
