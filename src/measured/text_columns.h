#pragma once
#include <cstddef>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace aberfit::internal {

/// The largest text a reader takes; what is beyond is refused before it is stored.
struct TextLimits {
  std::size_t line_length = std::size_t(1) << 24;  ///< characters of one line
  std::size_t numbers = std::size_t(1) << 26;      ///< of one file: a map of 8192 x 8192
};

/// The lines of a text file one after the other. Lines end with LF, CR LF or CR; a UTF-8 byte order mark is
/// skipped. Throws InputError for what is no regular file, for a line that is too long, and for UTF-16 and
/// binary files (bytes that are zero).
class TextLines {
 public:
  TextLines(const std::string& path, const TextLimits& limits);
  /// The next line without its end; false at the end of the file. The view lives until the next call.
  bool next(std::string_view* line);
  /// Number of the line that `next` gave last, from 1.
  long number() const { return number_; }

 private:
  bool fill();

  std::string path_;
  TextLimits limits_;
  std::ifstream file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::string line_;
  long number_ = 0;
  bool after_return_ = false;
};

/// Throws InputError "<path>: line <line>: found <found>; allowed: <allowed>".
[[noreturn]] void fail_at_line(const std::string& path, long line, const std::string& found,
                               const std::string& allowed);
/// 'text' for a message: at most 40 characters, unprintable ones as '?'.
std::string in_quotes(std::string_view text);

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// ';', tab or ',' when the line holds one, in this order; else ' ', which stands for runs of blanks.
char delimiter_of(std::string_view line);
void split(std::string_view line, char delimiter, std::vector<std::string_view>* fields);
/// The number; NaN for a hole (empty, "nan", "--"); infinity for "inf"; nothing for any other text.
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

/// "of", "pitch", "unit", "x_unit", "quantity", "wavelength", "layout", "label".
const std::vector<std::string>& known_text_keys();
/// Key and value of a comment line (with its '#'), if its key is known.
std::optional<std::pair<std::string, std::string>> comment_key(std::string_view line);

struct TextRules {
  long skip_lines = 0;  ///< lines before the numbers, whatever they hold
  bool plain = false;   ///< columns between blanks only and no row of names
  TextLimits limits;
};

/// Reads rows of numbers. '#' starts a comment. Before the first row one row of names may stand, or the last
/// comment before it names as many columns as there are. Throws InputError with the line.
TextTable read_text_table(const std::string& path, const TextRules& rules);

}  // namespace aberfit::internal
