#include "aberfit/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

constexpr const char* kTextAllowed = "a text file (ASCII, UTF-8 or UTF-16)";
constexpr std::size_t kLongestLine = std::size_t(1) << 24;

// Shifts every character from `first` to `last` by `shift`.
std::string shifted(std::string_view text, char first, char last, int shift) {
  std::string result(text);
  for (char& c : result)
    if (c >= first && c <= last) c = char(c + shift);
  return result;
}

unsigned byte_at(std::string_view text, std::size_t at) { return static_cast<unsigned char>(text[at]); }

// Number of bytes of the UTF-8 character that begins at `at`; 0 if there is none.
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const unsigned first = byte_at(text, at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf5   ? 0
                             : first >= 0xf0 ? 4
                             : first >= 0xe0 ? 3
                             : first >= 0xc2 ? 2
                                             : 0;
  if (length == 0 || length > text.size() - at) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte_at(text, at + i) & 0xc0) != 0x80) return 0;
  return length;
}

// Appends a code below 2^16; the halves of a surrogate pair become '?'.
void append_utf8(unsigned code, std::string* text) {
  if (code >= 0xd800 && code < 0xe000) code = '?';
  if (code < 0x80) {
    *text += char(code);
  } else if (code < 0x800) {
    *text += char(0xc0 | (code >> 6));
    *text += char(0x80 | (code & 0x3f));
  } else {
    *text += char(0xe0 | (code >> 12));
    *text += char(0x80 | ((code >> 6) & 0x3f));
    *text += char(0x80 | (code & 0x3f));
  }
}

struct Utf16 {
  bool found = false, big_endian = false;
};

// Without a mark the first two characters decide; they are ASCII in a table of numbers.
Utf16 utf16_of(std::string_view bytes) {
  if (bytes.starts_with("\xff\xfe")) return {true, false};
  if (bytes.starts_with("\xfe\xff")) return {true, true};
  if (bytes.size() < 4) return {};
  const auto ascii = [&](std::size_t at) {
    const unsigned c = byte_at(bytes, at);
    return (c >= ' ' && c <= '~') || c == '\t' || c == '\r' || c == '\n';
  };
  if (ascii(0) && bytes[1] == 0 && ascii(2) && bytes[3] == 0) return {true, false};
  if (bytes[0] == 0 && ascii(1) && bytes[2] == 0 && ascii(3)) return {true, true};
  return {};
}

std::string from_utf16(std::string_view bytes, bool big_endian) {
  std::string text;
  text.reserve(bytes.size());
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    append_utf8(byte_at(bytes, i + (big_endian ? 0 : 1)) * 256 + byte_at(bytes, i + (big_endian ? 1 : 0)),
                &text);
  return text;
}

// Returns true for digits, one comma, digits, with an optional sign, decimals and exponent.
bool has_decimal_comma(std::string_view word) {
  const std::size_t comma = word.find(',');
  if (comma == std::string_view::npos || word.find(',', comma + 1) != std::string_view::npos) return false;
  std::string number(word);
  number[comma] = '.';
  const auto digit = [&](std::size_t at) { return at < word.size() && word[at] >= '0' && word[at] <= '9'; };
  return comma > 0 && digit(comma - 1) && digit(comma + 1) && parse_finite(number).has_value();
}

}  // namespace

std::string utf8_text(std::string_view bytes) {
  const Utf16 encoding = utf16_of(bytes);
  return encoding.found ? from_utf16(bytes, encoding.big_endian) : std::string(bytes);
}

std::string with_plain_blanks(std::string_view line) {
  if (std::all_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; }))
    return std::string(line);
  bool valid = true;
  for (std::size_t at = 0; at < line.size() && valid;) {
    const std::size_t length = utf8_length(line, at);
    valid = length > 0;
    at += length;
  }
  std::string text;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t length = valid ? utf8_length(line, at) : 1;
    const std::string_view character = line.substr(at, length);
    at += length;
    if (!valid && byte_at(character, 0) == 0xa0)
      text += ' ';
    else if (!valid)
      append_utf8(byte_at(character, 0), &text);
    else if (character == "\u00a0" || character == "\u202f" || character == "\u2007" ||
             character == "\u2009" || character == "\ufeff")
      text += ' ';
    else
      text += character;
  }
  return text;
}

std::optional<std::string> decimal_comma(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return std::nullopt;
  // With other separators one such column is enough; with blanks every word must be such a number.
  const bool separated = line.find_first_of(";\t\"") != std::string_view::npos;
  const std::vector<std::string_view> cells = words(line, separated ? ";\t\"" : kBlanks);
  if (!separated && cells.size() < 2) return std::nullopt;
  std::optional<std::string> found;
  for (const std::string_view cell : cells) {
    const std::string_view word = trimmed(cell);
    if (has_decimal_comma(word)) {
      if (!found) found = word;
    } else if (!separated && !parse_number<double>(word)) {
      return std::nullopt;
    }
  }
  return found;
}

std::string grouped(double whole) {
  const std::string digits = fmt::format("{:.0f}", whole);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

void find_words(std::string_view text, std::string_view separators, std::vector<std::string_view>* found) {
  found->clear();
  for (std::size_t begin = text.find_first_not_of(separators); begin != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    found->push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(separators, end);
  }
}

std::vector<std::string_view> words(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> found;
  find_words(text, separators, &found);
  return found;
}

std::string lower_case(std::string_view text) { return shifted(text, 'A', 'Z', 'a' - 'A'); }
std::string upper_case(std::string_view text) { return shifted(text, 'a', 'z', 'A' - 'a'); }

std::vector<std::string> near_words(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string wanted = lower_case(word);
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& candidate : candidates) {
    const std::string other = lower_case(candidate);
    std::vector<std::size_t> row(other.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= wanted.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j < row.size(); ++j) {
        const std::size_t replace = diagonal + (wanted[i - 1] != other[j - 1] ? 1 : 0);
        diagonal = row[j];
        row[j] = std::min({replace, row[j] + 1, row[j - 1] + 1});
      }
    }
    const bool is_beginning = wanted.size() > 1 && other.starts_with(wanted);
    if (is_beginning || row.back() <= std::max<std::size_t>(1, wanted.size() / 2))
      near.emplace_back(is_beginning ? 1 : row.back(), candidate);
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [distance, name] : near) names.push_back(std::move(name));
  return names;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "'";
  std::size_t at = 0;
  while (at < text.size() && at < kLongest) {
    const std::size_t length = utf8_length(text, at);
    const bool printable = length > 1 || (length == 1 && text[at] >= ' ' && text[at] <= '~');
    shown += printable ? text.substr(at, length) : "?";
    at += std::max<std::size_t>(1, length);
  }
  return shown + (at < text.size() ? "...'" : "'");
}

std::optional<std::string> file_bytes(const std::string& path, std::uintmax_t most) {
  std::error_code problem;
  // A device or a pipe has no size that limits the reading.
  if (!std::filesystem::is_regular_file(path, problem)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  const std::uintmax_t size = std::min(most, std::filesystem::file_size(path, problem));
  if (!file || problem) return std::nullopt;
  std::string bytes(std::size_t(size), '\0');
  file.read(bytes.data(), std::streamsize(size));
  return std::uintmax_t(file.gcount()) == size ? std::optional(std::move(bytes)) : std::nullopt;
}

void fail_at_line(const std::string& path, long line, const std::string& found, const std::string& allowed) {
  throw InputError(path, fmt::format("line {}", line), found, allowed);
}

std::string_view before_comment(std::string_view line) {
  std::size_t hash = line.find('#');
  while (hash != std::string_view::npos && hash > 0 && kBlanks.find(line[hash - 1]) == kBlanks.npos)
    hash = line.find('#', hash + 1);
  return line.substr(0, hash);
}

bool is_old_windows_nan(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  const auto is_part = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-'; };
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (!text.starts_with("1.#")) return false;
  text.remove_prefix(3);
  return !text.empty() && is_letter(text.front()) && std::all_of(text.begin(), text.end(), is_part);
}

std::optional<double> parse_finite(std::string_view text) {
  const std::optional<double> value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

TextLines::TextLines(const std::string& path) : path_(path) {
  std::error_code error;
  // Only files: a pipe could block, and a folder opens without an error.
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path, "", "no file", "the name of a readable file");
  unread_ = std::size_t(std::filesystem::file_size(path, error));
  file_.open(path, std::ios::binary);
  if (!file_) throw InputError(path, "", "a file that cannot be opened", "the name of a readable file");
  if (!fill()) return;
  if (std::string_view(buffer_.data(), end_).starts_with("\xef\xbb\xbf")) begin_ = 3;
}

bool TextLines::fill() {
  constexpr std::size_t kBlock = std::size_t(1) << 16;
  const bool first = buffer_.empty();
  buffer_.resize(kBlock);
  const auto read = [&](std::size_t from) {
    file_.read(buffer_.data() + from, std::streamsize(buffer_.size() - from));
    end_ = from + std::size_t(file_.gcount());
    unread_ -= std::min(unread_, std::size_t(file_.gcount()));
  };
  begin_ = 0;
  read(0);
  // UTF-16 is decoded as a whole: spreadsheets write such files, and they are small.
  if (first && utf16_of({buffer_.data(), end_}).found) {
    buffer_.resize(end_ + unread_);
    read(end_);
    const std::string text = utf8_text({buffer_.data(), end_});
    buffer_.assign(text.begin(), text.end());
    end_ = buffer_.size();
  }
  if (file_.bad()) throw InputError(path_, "", "a file that cannot be read to its end", kTextAllowed);
  return end_ > 0;
}

bool TextLines::next(std::string_view* line) {
  line_.clear();
  for (bool any = false;; any = true) {
    if (begin_ == end_ && !fill()) {
      if (!any || line_.empty()) return false;
      break;
    }
    // Skips the LF of a CR LF whose CR ended the previous line.
    if (after_return_ && buffer_[begin_] == '\n') ++begin_;
    after_return_ = false;
    const auto first = buffer_.begin() + std::ptrdiff_t(begin_),
               last = buffer_.begin() + std::ptrdiff_t(end_);
    const auto stop = std::find_if(first, last, [](char c) { return c == '\n' || c == '\r' || c == '\0'; });
    line_.append(first, stop);
    if (line_.size() > kLongestLine)
      fail_at_line(path_, number_ + 1, fmt::format("more than {} characters", kLongestLine), "shorter lines");
    begin_ = std::size_t(stop - buffer_.begin());
    if (stop == last) continue;
    if (*stop == '\0') fail_at_line(path_, number_ + 1, "a zero byte, as in a binary file", kTextAllowed);
    after_return_ = *stop == '\r';
    ++begin_;
    break;
  }
  ++number_;
  if (std::any_of(line_.begin(), line_.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; }))
    line_ = with_plain_blanks(line_);
  *line = line_;
  return true;
}

std::size_t TextLines::bytes_left() const { return unread_ + (end_ - begin_); }

void TextLines::fail(const std::string& found, const std::string& allowed) const {
  fail_at_line(path_, number_, found, allowed);
}

}  // namespace aberfit
