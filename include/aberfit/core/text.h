#pragma once
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Lines, words and numbers of text files.
namespace aberfit {

/// Blanks, tabs, remains of line ends, and the Ctrl-Z at the end of DOS files.
inline constexpr std::string_view kBlanks = " \t\r\n\v\f\x1a";

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);
/// The non-empty parts between separators.
std::vector<std::string_view> words(std::string_view text, std::string_view separators = kBlanks);
/// The same into a vector whose memory is reused.
void find_words(std::string_view text, std::string_view separators, std::vector<std::string_view>* found);
/// ASCII only; other characters stay.
std::string lower_case(std::string_view text);
std::string upper_case(std::string_view text);
/// The candidates that begin with `word`, and those that differ from it in at most half of its letters
/// (Levenshtein distance), ignoring case. The nearest come first; equally near ones keep their order.
std::vector<std::string> near_words(std::string_view word, const std::vector<std::string>& candidates);
/// 'text' for a message: at most 40 bytes of UTF-8, with '?' for unprintable characters.
std::string in_quotes(std::string_view text);

/// Bytes of a file as UTF-8. UTF-16 is recognised by its byte order mark, or by the zero byte beside each of
/// its first two characters. Other bytes stay; characters beyond 16 bits become '?'.
std::string utf8_text(std::string_view bytes);
/// A line of text as UTF-8 with ordinary blanks. Bytes that are not UTF-8 count as Windows-1252, in which
/// instruments write their units; no-break, thin and figure spaces become blanks.
std::string with_plain_blanks(std::string_view line);

/// The first number of a line that has a decimal comma, "0,1"; empty if there is none. A comma is a decimal
/// comma where columns have another separator: ';', tab, quotes, or blanks where every one of two or more
/// words has a single comma between digits.
std::optional<std::string> decimal_comma(std::string_view line);
/// The advice for it in a message.
inline constexpr const char* kDecimalPoint =
    "numbers with a decimal point: write 0.1 instead of 0,1 (the export of the instrument or an editor can "
    "do that)";

/// A non-negative integer with its digits in groups of three: "307,200".
std::string grouped(double whole);

/// The first bytes of a regular file, at most `most` of them; empty when it cannot be read.
std::optional<std::string> file_bytes(const std::string& path,
                                      std::uintmax_t most = std::numeric_limits<std::uintmax_t>::max());

/// Throws InputError "<path>: line <line>: found <found>; allowed: <allowed>".
[[noreturn]] void fail_at_line(const std::string& path, long line, const std::string& found,
                               const std::string& allowed);

/// The line without its comment. A comment begins at a '#' that is first in the line or follows a blank; a
/// '#' inside a word ("1.#QNAN0", "x#1") belongs to the word.
std::string_view before_comment(std::string_view line);

/// True for the text that the C runtime of older Windows writes for a double that is not finite: an optional
/// sign, "1.#", then a letter and further letters and digits. Examples: "1.#QNAN0", "-1.#IND00", "1.#INF",
/// "1.#R".
bool is_old_windows_nan(std::string_view text);

/// The number that the whole `text` represents; empty for other text and beyond the range of `Number`. One
/// '+' may precede it. For a double, "inf" and "nan" are numbers, and text of is_old_windows_nan is NaN.
template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  if (text.starts_with("+-")) return std::nullopt;
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error == std::errc{} && end == last) return value;
  if constexpr (std::is_floating_point_v<Number>)
    if (is_old_windows_nan(text)) return std::numeric_limits<Number>::quiet_NaN();
  return std::nullopt;
}
/// The same for finite numbers only.
std::optional<double> parse_finite(std::string_view text);

/// The lines of a text file one after the other, converted by `utf8_text` and `with_plain_blanks`. Lines end
/// with LF, CR LF or CR; a byte order mark is skipped. Throws InputError for anything but a regular file, for
/// a line of more than 2^24 characters (before it is stored), and for binary files (with zero bytes).
class TextLines {
 public:
  explicit TextLines(const std::string& path);
  /// Reads the next line without its end; false at the end. The view is valid until the next call.
  bool next(std::string_view* line);
  /// Number of the line that `next` read last, from 1.
  long number() const { return number_; }
  /// Bytes of the file after that line.
  std::size_t bytes_left() const;
  /// Calls fail_at_line with that line.
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const;

 private:
  bool fill();

  std::string path_;
  std::ifstream file_;
  std::size_t unread_ = 0;  // bytes of the file that are not yet in the buffer
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::string line_;
  long number_ = 0;
  bool after_return_ = false;
};

}  // namespace aberfit
