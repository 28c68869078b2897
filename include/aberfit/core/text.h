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

/// Blanks, tabs, what is left of line ends, and the Ctrl-Z at the end of files of DOS.
inline constexpr std::string_view kBlanks = " \t\r\n\v\f\x1a";

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);
/// What stands between separators, nothing of it empty.
std::vector<std::string_view> words(std::string_view text, std::string_view separators = kBlanks);
/// The same in a vector whose memory is used again.
void find_words(std::string_view text, std::string_view separators, std::vector<std::string_view>* found);
/// Of ASCII; other characters stay.
std::string lower_case(std::string_view text);
std::string upper_case(std::string_view text);
/// 'text' for a message: at most 40 bytes of UTF-8, unprintable ones as '?'.
std::string in_quotes(std::string_view text);

/// Bytes of a file as UTF-8: UTF-16 is known by its byte order mark, or by the zero byte beside each of its
/// first two characters. Other bytes stay; of characters beyond 16 bits '?' is left.
std::string utf8_text(std::string_view bytes);
/// A line of text as UTF-8 with ordinary blanks: bytes that are no UTF-8 are taken for Windows-1252, where
/// instruments write their units, and no-break, thin and figure spaces become blanks.
std::string with_plain_blanks(std::string_view line);

/// The first number of a line that is written with a decimal comma, "0,1"; nothing where there is none. A
/// comma counts as one where columns are separated by something else: by ';', tab, quotes, or blanks where
/// every word of two or more has a single comma between digits.
std::optional<std::string> decimal_comma(std::string_view line);
/// What to do about it, for a message.
inline constexpr const char* kDecimalPoint =
    "numbers with a decimal point: write 0.1 for 0,1, as the export of the instrument or an editor can";

/// A whole number that is not negative, its digits in groups of three: "307,200".
std::string grouped(double whole);

/// The first bytes of a regular file, `most` of them at most; nothing when it cannot be read.
std::optional<std::string> file_bytes(const std::string& path,
                                      std::uintmax_t most = std::numeric_limits<std::uintmax_t>::max());

/// Throws InputError "<path>: line <line>: found <found>; allowed: <allowed>".
[[noreturn]] void fail_at_line(const std::string& path, long line, const std::string& found,
                               const std::string& allowed);

/// The line without its comment, which begins at a '#' that is first in the line or stands behind a blank: a
/// '#' inside a word ("1.#QNAN0", "x#1") belongs to the word.
std::string_view before_comment(std::string_view line);

/// True for what programs built with the C runtime of older Windows write for a double that is no number or
/// no finite one: an optional sign, "1.#", then a letter and further letters and digits, such as "1.#QNAN0",
/// "-1.#IND00", "1.#INF" and, cut to few digits, "1.#R".
bool is_old_windows_nan(std::string_view text);

/// The number that all of `text` is; nothing for other text and beyond the range of `Number`. One '+' may
/// stand before it. For a double "inf" and "nan" are numbers, and is_old_windows_nan is "nan".
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
/// The same of a finite number.
std::optional<double> parse_finite(std::string_view text);

/// The lines of a text file one after the other, as `utf8_text` and `with_plain_blanks` make them. Lines end
/// with LF, CR LF or CR; a byte order mark is skipped. Throws InputError for what is no regular file, for a
/// line of more than 2^24 characters (before it is stored), and for binary files (bytes that are zero).
class TextLines {
 public:
  explicit TextLines(const std::string& path);
  /// The next line without its end; false at the end of the file. The view lives until the next call.
  bool next(std::string_view* line);
  /// Number of the line that `next` gave last, from 1.
  long number() const { return number_; }
  /// Bytes of the file behind that line.
  std::size_t bytes_left() const;
  /// fail_at_line with that line.
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const;

 private:
  bool fill();

  std::string path_;
  std::ifstream file_;
  std::size_t unread_ = 0;  // bytes of the file that are not in the buffer yet
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::string line_;
  long number_ = 0;
  bool after_return_ = false;
};

}  // namespace aberfit
