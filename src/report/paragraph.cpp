#include "paragraph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/text.h"
#include "aberfit/core/units.h"

namespace aberfit::internal {

std::string paragraph(const std::string& label, const std::string& text, std::size_t indent,
                      std::size_t width) {
  const std::string line = fmt::format("{}", fmt::join(words(text, " \t\n\v\f\r"), " "));
  return fmt::format("{:<{}}{}\n", label, indent, wrapped(line, width - std::min(width, indent), indent));
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::string out, line;
  std::size_t begin = 0;
  while (begin < text.size()) {
    std::size_t end = text.find(' ', begin);
    if (end == std::string::npos) end = text.size();
    const std::string word = text.substr(begin, end - begin);
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      out += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return out + line;
}

std::string clear_text(const ClearRegion& clear) {
  std::string text = clear.aperture ? "; clear aperture: " + clear.text() : "";
  if (clear.said_invalid)
    text += *clear.said_invalid == 0 ? "; no sample has a value of `invalid`"
                                     : fmt::format("; {} with a value of `invalid` became holes",
                                                   plural(*clear.said_invalid, "sample"));
  if (clear.taken_out > 0) text += fmt::format("; {} left out", plural(clear.taken_out, "sample"));
  return text;
}

std::string plural(long count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string four_digits(double value, Dimension dimension) {
  if (!std::isfinite(value)) return "-";
  const std::string text = format_quantity(value, dimension);
  const std::size_t unit = std::min(text.find(' '), text.size());
  std::string digits = fmt::format("{:#.4g}", std::stod(text.substr(0, unit)));
  if (digits.back() == '.') digits.pop_back();
  return digits + text.substr(unit);
}

std::string metres_text(double metres) { return format_quantity(metres, Dimension::kLength); }

std::string pitches_text(double pitch_x, double pitch_y) {
  const std::string x = metres_text(pitch_x), y = metres_text(pitch_y);
  return x == y ? x + " along x and y" : x + " along x, " + y + " along y";
}

}  // namespace aberfit::internal
