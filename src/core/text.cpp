#include "aberfit/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

constexpr const char* kTextAllowed = "a text file (ASCII or UTF-8)";
constexpr std::size_t kLongestLine = std::size_t(1) << 24;

// Every character from `first` to `last` moved by `shift`.
std::string shifted(std::string_view text, char first, char last, int shift) {
  std::string result(text);
  for (char& c : result)
    if (c >= first && c <= last) c = char(c + shift);
  return result;
}

}  // namespace

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

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (text.size() > kLongest ? "...'" : "'");
}

std::optional<std::string> file_bytes(const std::string& path, std::uintmax_t most) {
  std::error_code problem;
  // A device or a pipe has no size to bound what is read from it.
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

TextLines::TextLines(const std::string& path) : path_(path), buffer_(std::size_t(1) << 16) {
  std::error_code error;
  // A pipe could block and a folder opens without an error: only files.
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path, "", "no file", "the name of a file that can be read");
  unread_ = std::size_t(std::filesystem::file_size(path, error));
  file_.open(path, std::ios::binary);
  if (!file_)
    throw InputError(path, "", "a file that cannot be opened", "the name of a file that can be read");
  if (!fill()) return;
  const std::string_view head(buffer_.data(), end_);
  if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff"))
    throw InputError(path, "", "UTF-16 text", kTextAllowed);
  if (head.starts_with("\xef\xbb\xbf")) begin_ = 3;
}

bool TextLines::fill() {
  file_.read(buffer_.data(), std::streamsize(buffer_.size()));
  begin_ = 0;
  end_ = std::size_t(file_.gcount());
  unread_ -= std::min(unread_, end_);
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
    // The LF of a CR LF whose CR ended the line before.
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
    if (*stop == '\0')
      fail_at_line(path_, number_ + 1, "a byte that is zero, as in a binary file", kTextAllowed);
    after_return_ = *stop == '\r';
    ++begin_;
    break;
  }
  ++number_;
  *line = line_;
  return true;
}

std::size_t TextLines::bytes_left() const { return unread_ + (end_ - begin_); }

void TextLines::fail(const std::string& found, const std::string& allowed) const {
  fail_at_line(path_, number_, found, allowed);
}

}  // namespace aberfit
