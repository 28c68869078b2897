#include "paragraph.h"

#include <fmt/format.h>

#include <sstream>

namespace aberfit {

std::string paragraph(const std::string& label, const std::string& text, std::size_t indent) {
  std::string out, line = fmt::format("{:<{}}", label, indent);
  bool empty = true;
  std::istringstream words(text);
  for (std::string word; words >> word; empty = false) {
    if (!empty && line.size() + 1 + word.size() > kColumns) {
      out += line + "\n";
      line = std::string(indent, ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + word;
  }
  return out + line + "\n";
}

}  // namespace aberfit
