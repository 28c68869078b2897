#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"

namespace aberfit::internal {

/// Lines of a small text file with the errors of its reader: file, line, what was found, what is allowed.
class ListingLines {
 public:
  /// Throws InputError when the file cannot be read.
  ListingLines(const std::string& path, const std::string& what) : path_(path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path, "", "a file that cannot be opened", what);
    for (std::string line; std::getline(in, line);) lines_.push_back(std::move(line));
    if (in.bad()) throw InputError(path, "", "a file that cannot be read to its end", what);
  }

  /// Moves to the next line that is not blank; false at the end.
  bool next() {
    while (next_ < lines_.size())
      if (!(text_ = trim(lines_[next_++])).empty()) return true;
    return false;
  }
  /// The line moved to, without blanks at its ends.
  std::string_view text() const { return text_; }

  [[noreturn]] void fail(std::string_view found, const std::string& allowed) const {
    std::string shown;
    for (const char c : found.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
    throw InputError(path_, "line " + std::to_string(next_), "\"" + shown + "\"", allowed);
  }
  /// For what is missing from the file as a whole.
  [[noreturn]] void fail_whole(const std::string& found, const std::string& allowed) const {
    throw InputError(path_, "", found, allowed);
  }

  double number(std::string_view text, const std::string& what) const {
    double value = 0;
    std::string_view digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
      fail(text, what + ": a finite number");
    return value;
  }
  int integer(std::string_view text, const std::string& what) const {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) fail(text, what + ": an integer");
    return value;
  }

  static std::string_view trim(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
  }
  static std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> result;
    for (std::size_t begin = text.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
      const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
      result.push_back(text.substr(begin, end - begin));
      begin = text.find_first_not_of(kBlanks, end);
    }
    return result;
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\v\f";
  std::string path_;
  std::vector<std::string> lines_;
  std::size_t next_ = 0;  // also the number of the present line, from 1
  std::string_view text_;
};

}  // namespace aberfit::internal
