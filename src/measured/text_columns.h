#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/text.h"

namespace aberfit::internal {

/// ';', tab or ',' when the line holds one outside double quotes, in this order; else ' ', which stands for
/// runs of blanks.
char delimiter_of(std::string_view line);
/// What stands between delimiters outside double quotes; a field in quotes comes without them.
void split(std::string_view line, char delimiter, std::vector<std::string_view>* fields);
/// True where every field that is not empty is a unit, in brackets or without, such as "[mm];[nm]".
bool is_unit_row(std::string_view line);
/// The number; NaN for a hole (empty, "nan", "--", is_old_windows_nan); infinity for "inf"; nothing for any
/// other text.
std::optional<double> parse_cell(std::string_view text);

/// What a comment "# key = value" or "# key: value" says.
struct TextKey {
  std::string value;
  long line = 0;
};

/// Rows of numbers of equal length.
struct TextTable {
  std::string path;
  std::size_t columns = 0;
  std::vector<double> values;           ///< row after row; NaN for a hole, else finite
  std::vector<long> lines;              ///< line of each row in the file
  std::vector<std::string> names;       ///< of the columns, as written; empty when the file has none
  std::map<std::string, TextKey> keys;  ///< those comments whose key is one of `known_text_keys`

  std::size_t rows() const { return lines.size(); }
  double operator()(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// "of", "pitch", "unit", "x_unit", "quantity", "wavelength", "layout", "label", and what Gwyddion's text
/// export says: "channel", "width", "height", "value units".
const std::vector<std::string>& known_text_keys();
/// Key and value of a comment line (with its '#'), if its key is known.
std::optional<std::pair<std::string, std::string>> comment_key(std::string_view line);

struct TextRules {
  long skip_lines = 0;                              ///< lines before the numbers, whatever they hold
  bool plain = false;                               ///< columns between blanks only and no row of names
  std::size_t row_length = 0;                       ///< numbers of a row, which may go over lines; 0: a line
  std::size_t most_numbers = std::size_t(1) << 26;  ///< of one file: a map of 8192 x 8192
};

/// Reads rows of numbers. '#' starts a comment at the start of a line or after a blank. Before the first row
/// one row of names may stand and one of units below it, or the last comment before it names as many columns
/// as there are. Throws InputError with the line.
TextTable read_text_table(const std::string& path, const TextRules& rules);

}  // namespace aberfit::internal
