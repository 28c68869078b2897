#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/text.h"

namespace aberfit::internal {

/// Returns the first of ';', tab and ',' outside double quotes, otherwise ' ' for a run of blanks.
char delimiter_of(std::string_view line);
/// Splits at the delimiter outside double quotes; a quoted field is returned without its quotes.
void split(std::string_view line, char delimiter, std::vector<std::string_view>* fields);
/// Returns true if every non-empty field is a unit, with or without brackets, such as "[mm];[nm]".
bool is_unit_row(std::string_view line);
/// Returns the number; NaN if missing ("", "nan", "--", is_old_windows_nan); infinity for "inf"; or nothing.
std::optional<double> parse_cell(std::string_view text);

/// The value of a comment "# key = value" or "# key: value".
struct TextKey {
  std::string value;
  long line = 0;
};

/// Rows of numbers of equal length.
struct TextTable {
  std::string path;
  std::size_t columns = 0;
  std::vector<double> values;           ///< row after row; NaN for a missing value, otherwise finite
  std::vector<long> lines;              ///< line of each row in the file
  std::vector<std::string> names;       ///< column names as written; empty if the file has none
  std::map<std::string, TextKey> keys;  ///< comments whose key is one of `known_text_keys`

  std::size_t rows() const { return lines.size(); }
  double operator()(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Returns "of", "pitch", "unit", "x_unit", "quantity", "wavelength", "layout", "label", and the keys of
/// Gwyddion's text export: "channel", "width", "height", "value units".
const std::vector<std::string>& known_text_keys();
/// Returns key and value of a comment line (with its '#') if the key is known.
std::optional<std::pair<std::string, std::string>> comment_key(std::string_view line);

struct TextRules {
  long skip_lines = 0;         ///< lines to skip before the numbers, whatever they hold
  bool plain = false;          ///< columns are separated by blanks only and have no row of names
  std::size_t row_length = 0;  ///< numbers per row, which may extend over lines; 0: one line per row
  std::size_t most_numbers = std::size_t(1) << 26;  ///< per file: a map of 8192 x 8192
};

/// Reads rows of numbers. '#' starts a comment at the start of a line or after a blank. A row of names, with
/// an optional row of units, may precede the numbers; otherwise the last comment before them gives the names
/// if it has as many words as columns. Throws InputError with the line.
TextTable read_text_table(const std::string& path, const TextRules& rules);

}  // namespace aberfit::internal
