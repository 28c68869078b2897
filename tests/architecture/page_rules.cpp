#include "page_rules.h"

#include <algorithm>
#include <regex>

#include "source_rules.h"

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

// File and line of the place where a rule is broken.
std::string place(const fs::path& file, const std::string& text, std::size_t at) {
  const auto number = std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n') + 1;
  return file.string() + ":" + std::to_string(number) + ": ";
}

bool is_source(const fs::path& file) {
  return file.extension() == ".h" || file.extension() == ".cpp" || file.extension() == ".inc";
}

// The text as its reader sees it: comments without slashes, so that a reference may continue on the next
// line.
std::string prose_of(const fs::path& file, const std::string& text) {
  if (!is_source(file)) return text;
  std::string prose = comments_of(text);
  static const std::regex opening(R"(///?<?)");
  std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>> found;
  for (std::sregex_iterator it(prose.begin(), prose.end(), opening), end; it != end; ++it)
    if (it->position() == 0 || prose[std::size_t(it->position()) - 1] == ' ' ||
        prose[std::size_t(it->position()) - 1] == '\n')
      found.push_back({it->position(), it->length()});
  for (const auto& [at, length] : found) std::fill_n(prose.begin() + at, length, ' ');
  return prose;
}

bool is_there(const Pages& pages, const fs::path& file, const std::string& folders, const std::string& name) {
  const fs::path page = folders + name + ".md";
  if (!folders.empty())
    return pages.files.contains(page.lexically_normal()) ||
           pages.files.contains((file.parent_path() / page).lexically_normal());
  return std::any_of(pages.files.begin(), pages.files.end(),
                     [&](const fs::path& candidate) { return candidate.filename() == page; });
}

// Returns the problem of the sections that a reference names; empty if there is none.
std::string against_sections(const Pages& pages, const std::string& name, const std::smatch& match,
                             std::size_t first) {
  const auto known = pages.sections.find(name);
  for (std::size_t i = first; i < first + 2; ++i) {
    if (!match[i].matched) continue;
    const bool found = known != pages.sections.end() && known->second.contains(std::stoi(match[i]));
    if (!found) return name + " has no section " + match[i].str();
  }
  return "";
}

}  // namespace

std::set<int> sections_of(const std::string& page) {
  static const std::regex heading(R"((?:^|\n)#+ (\d{1,3})\. )");
  std::set<int> numbers;
  for (std::sregex_iterator it(page.begin(), page.end(), heading), end; it != end; ++it)
    numbers.insert(std::stoi((*it)[1]));
  return numbers;
}

std::vector<std::string> lost_references(const Pages& pages, const fs::path& file, const std::string& text) {
  // A number without decimals is a section.
  static const std::string numbers = R"((\d{1,3})(?!\.?\d)(?:\s+and\s+(\d{1,3})(?!\.?\d))?)";
  static const std::regex mention(R"(((?:[\w.-]+/)*)\b(?:([A-Z]{3,})\.md\b|(PHYSICS|FORMATS|DESIGN|STYLE)\b))"
                                  R"((?:[)\]`]*,?\s+(?:section\s+)?)" +
                                  numbers + ")?");
  static const std::regex own(R"(\b[Ss]ections?\s+)" + numbers);
  const std::string prose = prose_of(file, text);
  std::vector<std::string> found;
  const std::sregex_iterator end;
  for (std::sregex_iterator it(prose.begin(), prose.end(), mention); it != end; ++it) {
    const std::smatch& match = *it;
    const bool full = match[2].matched;  // with its suffix
    const std::string name = full ? match[2] : match[3];
    std::string problem;
    if (!is_there(pages, file, full ? match[1].str() : "", name))
      problem = match[1].str() + name + " is no page of this repository";
    else
      problem = against_sections(pages, name, match, 4);
    if (!problem.empty()) found.push_back(place(file, text, std::size_t(match.position())) + problem);
  }
  const std::string self = file.stem().string();
  if (is_source(file) || !pages.sections.contains(self)) return found;
  for (std::sregex_iterator it(prose.begin(), prose.end(), own); it != end; ++it)
    if (const std::string problem = against_sections(pages, self, *it, 1); !problem.empty())
      found.push_back(place(file, text, std::size_t(it->position())) + problem);
  return found;
}

std::vector<std::string> broken_links(const fs::path& root, const fs::path& file, const std::string& text) {
  std::string page = text;
  static const std::regex code(R"(```[^]*?```|`[^`\n]*`)");
  for (std::sregex_iterator it(text.begin(), text.end(), code), end; it != end; ++it)
    for (std::ptrdiff_t i = 0; i < it->length(); ++i)
      if (char& c = page[std::size_t(it->position() + i)]; c != '\n') c = '`';
  static const std::regex link(R"(\]\(([^()\s]*)\))");
  static const std::regex elsewhere(R"([a-z]+:.*)");
  std::vector<std::string> found;
  for (std::sregex_iterator it(page.begin(), page.end(), link), end; it != end; ++it) {
    const std::string whole = (*it)[1], target = whole.substr(0, whole.find('#'));
    if (std::regex_match(whole, elsewhere) || (target.empty() && !whole.empty())) continue;
    if (target.empty() || !fs::exists(root / file.parent_path() / target))
      found.push_back(place(file, text, std::size_t(it->position())) + "[](" + whole + ") leads to no file");
  }
  return found;
}

}  // namespace aberfit::test
