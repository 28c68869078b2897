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

/// Everything in fits/paper-verify/README.md that stands behind this line is written by `paper_page`.
inline constexpr const char* kPaperPageMark =
    "<!-- tests/fits/paper_audit_test.cpp writes what follows -->\n";

/// `text` in lines of at most 110 characters, the second and later ones indented.
inline std::string wrapped_line(const std::string& text, const std::string& indent) {
  std::string lines, line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.size() + 1 + word.size() > 110) {
      lines += line + "\n";
      line = indent + word;
    } else {
      line += (line.empty() || at == 0 ? "" : " ") + word;
    }
    at = end + 1;
  }
  return lines + line + "\n";
}

inline std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}
/// Four digits; a length that is nothing but rounding is 0.
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

/// The table of R: printed value and ours of its 36 cells.
inline std::string paper_page_of_cells(const std::vector<PaperAnswer>& answers) {
  std::string text = "| sigma, l_c | D = 0.2 m | 0.5 m | 1.0 m |\n|---|---|---|---|\n";
  int column = 0;
  for (const PaperAnswer& a : answers) {
    if (a.number.formula != "cell") continue;
    const std::string& label = a.number.label;  // R at sigma 1 nm, l_c 1 um, D 0.2 m
    if (column == 0)
      text += "| " + label.substr(11, label.find(", l_c") - 11) + ", " +
              label.substr(label.find("l_c") + 4, label.find(", D") - label.find("l_c") - 4);
    text += fmt::format(" | {} ({})", a.number.printed, four_digits(a.ours));
    column = (column + 1) % 3;
    if (column == 0) text += " |\n";
  }
  return text;
}

/// What is computed, section by section: printed, ours and the verdict, and the reading of what does not
/// simply hold. What is printed a second time is left out.
inline std::string paper_page(const std::vector<PaperAnswer>& answers) {
  std::map<std::string, int> count;
  std::string tally, section, readings, text;
  const auto flush = [&] {
    text += readings.empty() ? "" : "\n" + readings;
    readings.clear();
  };
  for (const PaperAnswer& a : answers) {
    const PaperNumber& n = a.number;
    const bool is_papers = n.kind != "derived" && n.kind != "reading";
    if (is_papers) ++count[n.verdict];
    if (n.verdict == "input" || n.formula == "cell" || n.label.ends_with(", repeated")) continue;
    if (!std::isfinite(a.ours) && n.verdict != "not-reproducible") continue;
    if (n.section != section) {
      flush();
      section = n.section;
      text += "\n## " + section + "\n\n";
      if (section.starts_with("A.2"))
        text += "R at 500 nm, printed and (ours):\n\n" + paper_page_of_cells(answers) + "\n";
      text += "| number | printed | ours | verdict |\n|---|---|---|---|\n";
    }
    const std::string printed = n.printed.size() > 24      ? "formula"
                                : std::isfinite(n.value()) ? with_unit(n.printed, n.unit)
                                                           : n.printed;
    text += fmt::format("| {} | {}{} | {} | {} |\n", n.label, printed,
                        n.kind == "derived" ? " (derived)" : "", our_cell(a), n.verdict);
    if (is_papers && n.verdict != "holds")
      readings += wrapped_line("- *" + n.label + "*: " + n.reading, "  ");
  }
  flush();
  for (const auto& [word, number] : count)
    tally += fmt::format("{}{} {}", tally.empty() ? "" : ", ", number, word);
  return "\n" + wrapped_line("Verdicts of the paper's numbers, claims and figures: " + tally + ".", "") +
         text;
}

}  // namespace aberfit::test
