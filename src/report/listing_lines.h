#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"

namespace aberfit::internal {

/// Lines of a small text file. Errors of its reader name file, line, what was found and what is allowed.
class ListingLines {
 public:
  explicit ListingLines(const std::string& path) : path_(path), lines_(path) {}

  /// Moves to the next line that is not blank; false at the end.
  bool next() {
    std::string_view line;
    while (lines_.next(&line))
      if (!(text_ = trimmed(line)).empty()) return true;
    return false;
  }
  /// The current line without blanks at its ends.
  std::string_view text() const { return text_; }
  long line() const { return lines_.number(); }

  [[noreturn]] void fail(std::string_view found, const std::string& allowed) const {
    std::string shown;
    for (const char c : found.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
    throw InputError(path_, "line " + std::to_string(line()), "\"" + shown + "\"", allowed);
  }
  /// Error for something missing in the whole file.
  [[noreturn]] void fail_whole(const std::string& found, const std::string& allowed) const {
    throw InputError(path_, "", found, allowed);
  }

  double number(std::string_view text, const std::string& what) const {
    const std::optional<double> value = parse_finite(text);
    if (!value) fail(text, what + ": a finite number");
    return *value;
  }
  int integer(std::string_view text, const std::string& what) const {
    const std::optional<int> value = parse_number<int>(text);
    if (!value) fail(text, what + ": an integer");
    return *value;
  }

 private:
  std::string path_;
  TextLines lines_;
  std::string_view text_;
};

}  // namespace aberfit::internal
