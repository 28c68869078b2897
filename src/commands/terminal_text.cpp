#include "aberfit/commands/terminal_text.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "aberfit/core/text.h"

namespace aberfit {
namespace {

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

int characters(std::string_view text) {
  return int(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

int text_width() {
  constexpr int kUsual = 80, kLeast = 40, kMost = 120;
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  const int columns = parse_number<int>(environment("COLUMNS")).value_or(known ? int(size.ws_col) : kUsual);
  return std::clamp(columns, kLeast, kMost);
}

std::string wrapped(std::string_view text, int width, int indent) {
  std::string result;
  int column = 0;
  for (const std::string_view word : words(text, " \n")) {
    const int length = characters(word);
    if (column > indent && column + 1 + length > width) {
      result += '\n' + std::string(std::size_t(indent), ' ');
      column = indent;
    } else if (!result.empty()) {
      result += ' ';
      ++column;
    }
    result += word;
    column += length;
  }
  return result;
}

bool takes_escapes(std::FILE* stream) {
  const std::string_view term = environment("TERM");
  return isatty(fileno(stream)) == 1 && !term.empty() && term != "dumb";
}

bool takes_colour(std::FILE* stream) { return takes_escapes(stream) && environment("NO_COLOR").empty(); }

std::string toned(std::string_view text, Tone tone, std::FILE* stream) {
  static const char* const kCodes[] = {"1", "1;32", "1;33", "1;31"};
  if (!takes_colour(stream)) return std::string(text);
  return fmt::format("\x1b[{}m{}\x1b[0m", kCodes[std::size_t(tone)], text);
}

}  // namespace aberfit
