#pragma once
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "fits/paper_numbers.h"

namespace aberfit::test {

/// A number of the paper with ours beside it [printed unit].
struct PaperAnswer {
  PaperNumber number;
  double ours = 0;  ///< NaN: nothing is computed
  bool compared = false, holds = false;
};

/// `paper_page` writes everything after this line of fits/paper-verify/README.md.
inline constexpr const char* kPaperPageMark =
    "<!-- tests/fits/paper_audit_test.cpp writes what follows -->\n";

inline std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}
/// Four digits; a length that is only rounding is 0.
inline std::string four_digits(double value) {
  return std::abs(value) >= 1e4 && std::abs(value) < 1e6 ? fmt::format("{:.0f}", value)
                                                         : fmt::format("{:.4g}", value);
}
inline std::string our_cell(const PaperAnswer& answer) {
  if (!std::isfinite(answer.ours)) return "-";
  const bool is_rounding =
      answer.number.unit.ends_with("m") && std::abs(answer.ours * answer.number.si) < 1e-14;
  const bool is_long = answer.number.unit.find(' ') != std::string::npos;
  return with_unit(four_digits(is_rounding ? 0 : answer.ours), is_long ? "" : answer.number.unit);
}

/// The table of numbers that we compute and that do not simply hold: section, printed, ours and the verdict.
/// Inputs and repeated numbers are left out.
inline std::string paper_page(const std::vector<PaperAnswer>& answers) {
  std::map<std::string, int> count;
  std::string tally, table = "\n| section | number | printed | ours | verdict |\n|---|---|---|---|---|\n";
  for (const PaperAnswer& a : answers) {
    const PaperNumber& n = a.number;
    if (n.kind != "derived" && n.kind != "reading") ++count[n.verdict];
    if (n.verdict == "input" || n.verdict == "holds" || n.label.ends_with(", repeated")) continue;
    if (!std::isfinite(a.ours) && n.verdict != "not-reproducible") continue;
    const std::string printed = n.printed.size() > 24      ? "formula"
                                : std::isfinite(n.value()) ? with_unit(n.printed, n.unit)
                                                           : n.printed;
    table += fmt::format("| {} | {} | {}{} | {} | {} |\n", n.section.substr(0, n.section.find(' ')), n.label,
                         printed, n.kind == "derived" ? " (derived)" : "", our_cell(a), n.verdict);
  }
  for (const auto& [word, number] : count) tally += fmt::format("{} {}, ", number, word);
  tally.resize(tally.size() - 2);
  return "\nVerdicts of all 195:\n" + tally + ".\n" + table;
}

}  // namespace aberfit::test
