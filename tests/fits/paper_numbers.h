#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "aberfit/core/text.h"

namespace aberfit::test {

/// A number, claim or figure of the paper: one line of tests/data/paper/numbers.csv.
struct PaperNumber {
  std::string id, section, kind, label;
  std::string printed;     ///< digit for digit as the paper has it; may be words
  std::string unit;        ///< of the printed value and of ours
  double si = 1;           ///< the printed value times this is the SI value
  std::string what_it_is;  ///< how the paper defines it
  std::string formula;     ///< name of the function in paper_formulas.h; empty: nothing is computed
  std::string within;      ///< relative tolerance; empty: half of the last printed digit; or "condition"
  std::string verdict;     ///< the verdict that the comparison must reach
  std::string picture;     ///< the picture of `aberfit verify` that shows it; may be empty
  std::string reading;     ///< comment: what agrees and what does not

  /// The number in the printed unit; NaN if the paper prints words.
  double value() const { return parse_finite(printed).value_or(std::nan("")); }
};

/// The cells of a line of comma-separated values; a doubled quote inside quotes is a quote.
inline std::vector<std::string> csv_cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[i++];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += line[i];
  }
  return cells;
}

inline std::vector<PaperNumber> paper_numbers() {
  std::ifstream file(ABERFIT_TEST_DATA "/paper/numbers.csv");
  std::vector<PaperNumber> rows;
  std::string line;
  std::getline(file, line);  // the names of the columns
  while (std::getline(file, line)) {
    const std::vector<std::string> c = csv_cells(line);
    EXPECT_EQ(c.size(), 13u) << line;
    if (c.size() != 13) continue;
    rows.push_back({c[0], c[1], c[2], c[3], c[4], c[5], c[6].empty() ? 1.0 : std::stod(c[6]), c[7], c[8],
                    c[9], c[10], c[11], c[12]});
  }
  return rows;
}

/// Half a unit of the last printed digit: 0.005e-5 for "1.57e-5". NaN if the text is no number.
inline double half_last_digit(const std::string& printed) {
  if (!parse_finite(printed)) return std::nan("");
  const std::size_t mantissa_end = std::min(printed.find_first_of("eE"), printed.size());
  const std::size_t point = printed.find('.');
  const double decimals = point < mantissa_end ? double(mantissa_end - point - 1) : 0.0;
  const double exponent = mantissa_end < printed.size() ? std::stod(printed.substr(mantissa_end + 1)) : 0.0;
  return 0.5 * std::pow(10.0, exponent - decimals);
}

/// Returns whether ours [printed unit] agrees with a printed number. A bound met to the last bit counts as
/// met, because printed numbers are decimal and ours are binary.
inline bool agrees(const PaperNumber& row, double ours) {
  const double printed = row.value();
  const double within =
      row.within.empty() ? half_last_digit(row.printed) : std::stod(row.within) * std::abs(printed);
  return std::abs(ours - printed) <= within + 1e-12 * std::abs(printed);
}

}  // namespace aberfit::test
