#include "source_rules.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

// Rooms of their own, which may include all others.
const char* const kProgram = "the program";  // sources directly in src: main.cpp and what it is made of
const char* const kUmbrella = "aberfit.h";   // all public headers, and nothing else

// Rooms that may include each outside library, by the beginning of the included path (src/README.md, the
// table of rooms).
const std::map<std::string, std::set<std::string>>& libraries() {
  static const std::set<std::string> all = [] {
    std::set<std::string> names(rooms().begin(), rooms().end());
    names.insert(kProgram);
    return names;
  }();
  static const std::map<std::string, std::set<std::string>> table = {
      {"Eigen/", all},
      {"fmt/", all},
      {"Random123/", {"core"}},
      {"boost/math/", {"core", "roughness", "spectrum", "terms", "theory", "method", "specify"}},
      {"boost/random/sobol.hpp", {"cases"}},
      {"mpi.h", {"cases"}},
      {"dlfcn.h", {"cases"}},             // the module that includes MPI
      {"boost/version.hpp", {"report"}},  // a number for the provenance, no code
      {"fftw3.h", {"roughness", "terms", "waves"}},
      {"fitsio.h", {"measured"}},
      {"hdf5.h", {"measured"}},
      {"pugixml.hpp", {"measured"}},
      {"kainjow/", {"report"}},
      {"zip.h", {"measured"}},
      {"ceres/", {"spectrum", "fit"}},
      {"nlohmann/",
       {"measured", "report", "study", "cases", "commands", "python"}},  // DABAM metadata, results, studies
      {"CLI/", {kProgram}},
      {"pybind11/", {"python"}},
      // Headers of the operating system: memory, processes and files of gnuplot and the reports, the
      // terminal.
      {"unistd.h", {"core", "report", "cases", "commands"}},
      {"fcntl.h", {"report", "cases"}},
      {"poll.h", {"report"}},
      {"sys/", {"core", "report", "cases", "commands"}},
      {"malloc.h", {"core"}},
  };
  return table;
}

// Libraries whose headers the installed package must find for its user.
const std::set<std::string> kPublicLibraries = {"Eigen/", "nlohmann/", "fmt/"};

// Room of a path below the root: the folder under include/aberfit or src.
std::optional<std::string> room_of(const fs::path& file) {
  std::vector<std::string> parts;
  for (const fs::path& part : file.lexically_normal()) parts.push_back(part.string());
  if (parts.size() == 2 && parts[0] == "src") return kProgram;
  if (file.lexically_normal() == fs::path("include/aberfit") / kUmbrella) return kUmbrella;
  const bool header = parts.size() == 4 && parts[0] == "include" && parts[1] == "aberfit";
  const bool source = parts.size() == 3 && parts[0] == "src";
  if (!header && !source) return std::nullopt;
  const std::string& room = parts[parts.size() - 2];
  if (std::find(rooms().begin(), rooms().end(), room) == rooms().end()) return std::nullopt;
  return room;
}

std::size_t height(const std::string& room) {
  return std::size_t(std::find(rooms().begin(), rooms().end(), room) - rooms().begin());
}

std::string against_quoted(const fs::path& root, const fs::path& file, const std::string& room,
                           const std::string& included) {
  const fs::path target =
      included.starts_with("aberfit/") ? fs::path("include") / included : (file.parent_path() / included);
  if (!fs::exists(root / target)) return "is no file of this repository";
  const std::optional<std::string> other = room_of(target);
  if (!other) return "lies in no room";
  if (height(*other) > height(room)) return "is in " + *other + ", above " + room;
  if (!included.starts_with("aberfit/") && *other != room)
    return "is internal to " + *other + ", not to " + room;
  return "";
}

std::string against_angled(const fs::path& file, const std::string& room, const std::string& included) {
  for (const auto& [library, allowed] : libraries()) {
    if (!included.starts_with(library)) continue;
    if (!allowed.contains(room)) return "has no place in " + room;
    const bool header = file.string().starts_with("include");
    if (header && !kPublicLibraries.contains(library)) return "is a private dependency, in a public header";
    // A user of our headers should not have to compile all of JSON.
    if (header && library == "nlohmann/" && included != "nlohmann/json_fwd.hpp")
      return "is only named in public headers, by json_fwd.hpp";
    return "";
  }
  // Headers of the standard library have neither folder nor suffix.
  if (included.find_first_of("./") != std::string::npos)
    return "belongs to no library that src/README.md names";
  return "";
}

// The part of the text to which a character of a source belongs.
enum class Part : char { kCode, kQuoted, kComment };

std::vector<Part> parts_of(const std::string& text) {
  std::vector<Part> parts(text.size(), Part::kCode);
  const auto mark = [&](std::size_t begin, std::size_t end, Part part) {
    for (std::size_t i = begin; i < std::min(end, text.size()); ++i) parts[i] = part;
    return end;
  };
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = std::string_view(text).substr(i);
    if (rest.starts_with("//")) {
      i = mark(i, std::min(text.find('\n', i), text.size()), Part::kComment);
    } else if (rest.starts_with("/*")) {
      const std::size_t end = text.find("*/", i + 2);
      i = mark(i, end == std::string::npos ? text.size() : end + 2, Part::kComment);
    } else if (rest.starts_with("R\"") && (i == 0 || !is_word(text[i - 1]))) {
      const std::size_t open = text.find('(', i);
      const std::string close = ")" + text.substr(i + 2, open - i - 2) + "\"";
      const std::size_t end = text.find(close, i);
      i = mark(i, end == std::string::npos ? text.size() : end + close.size(), Part::kQuoted);
    } else if (text[i] == '"' || (text[i] == '\'' && (i == 0 || !is_word(text[i - 1])))) {  // not 1'000
      std::size_t end = i + 1;
      while (end < text.size() && text[end] != text[i] && text[end] != '\n') end += text[end] == '\\' ? 2 : 1;
      i = mark(i + 1, end, Part::kQuoted) + 1;
    } else {
      ++i;
    }
  }
  return parts;
}

// The text with only one kind of part; the rest is blank, on the same lines.
std::string only(Part wanted, const std::string& text) {
  const std::vector<Part> parts = parts_of(text);
  std::string left = text;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (parts[i] != wanted && text[i] != '\n') left[i] = ' ';
  return left;
}

std::string code_of(const std::string& text) { return only(Part::kCode, text); }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\n");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\n") - begin + 1);
}

// First and last line of a function, counted from 0.
struct Extent {
  std::size_t first, last;
};

// First line of the statement that opens a brace at the end of `line`.
std::size_t first_line_of_statement(const std::vector<std::string>& code, std::size_t line) {
  static const std::regex other(R"(\s*(#.*|(public|private|protected):))");
  std::size_t first = line;
  while (first > 0) {
    const std::string above = trimmed(code[first - 1]);
    if (above.empty() || std::string(";{}").find(above.back()) != std::string::npos) break;
    if (std::regex_match(above, other)) break;
    --first;
  }
  return first;
}

// Functions whose signature begins at this column, and not inside other functions.
std::vector<Extent> functions_at(const std::vector<std::string>& code, std::size_t columns,
                                 const std::vector<Extent>& others) {
  static const std::regex other(
      R"((template <.*> )?(namespace|class|struct|enum|union|extern|if|for|while|switch|do|else|case)\b.*)");
  const std::string indent(columns, ' ');
  std::vector<Extent> found;
  for (std::size_t line = 0; line < code.size(); ++line) {
    if (!trimmed(code[line]).ends_with("{")) continue;
    const auto holds = [&](const Extent& f) { return f.first <= line && line <= f.last; };
    if (std::any_of(others.begin(), others.end(), holds)) continue;
    const std::size_t first = first_line_of_statement(code, line);
    if (code[first].find_first_not_of(' ') != columns) continue;
    std::string signature;
    for (std::size_t i = first; i <= line; ++i) signature += trimmed(code[i]) + " ";
    if (signature.find('(') == std::string::npos || signature.ends_with("= { ")) continue;
    if (std::regex_match(signature, other)) continue;
    std::size_t last = line + 1;
    while (last < code.size() && !code[last].starts_with(indent + "}")) ++last;
    found.push_back({first, last});
    line = last;
  }
  return found;
}

// Sentence for a broken rule, with the line as it stands in the file.
std::string breach(const fs::path& file, const std::string& text, std::size_t at,
                   const std::string& problem) {
  const auto number = std::size_t(std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n')) + 1;
  return file.string() + ":" + std::to_string(number) + ": " + trimmed(lines_of(text)[number - 1]) + ": " +
         problem;
}

// Returns the problem of a mention of Study or Task, from the text before and after it; empty if there is
// none.
std::string against_mention(const std::string& before, std::string after) {
  static const std::regex ends_const(R"([^]*\bconst)"), begins_const(R"(const\b[^]*)");
  static const std::regex declared(R"([^]*\b(struct|class|using))");
  static const std::regex made(
      R"(\w+\s*=\s*(?!(?:aberfit::)?(?:Study|Task)\b|std::(?:move|forward)\b)[\w:.]+\([^]*)");
  if (after.starts_with("::")) return "";  // a name inside it
  if (std::regex_match(before, declared) && after.starts_with(";")) return "";
  bool is_const = std::regex_match(before, ends_const);
  if (std::regex_match(after, begins_const)) {
    is_const = true;
    after = trimmed(after.substr(5));
  }
  if (!is_const) return "is not const";
  const bool by_value = std::string("&*>").find(after.front()) == std::string::npos;
  return by_value && !std::regex_match(after, made) ? "is a copy" : "";
}

// A declaration directly in a namespace: the text before its `;` or `{`, and where that begins.
struct Declared {
  std::string space;  // a::b; empty: the global one
  std::string head;
  char end;  // ';' or '{'
  std::size_t at;
};

std::vector<Declared> declarations(std::string code) {
  static const std::regex opened(R"((?:inline\s+)?namespace\b\s*([\w:]*))");
  for (std::size_t at = 0; at < code.size(); at = std::min(code.find('\n', at), code.size() - 1) + 1)
    if (const std::size_t first = code.find_first_not_of(" \t", at);
        first < code.size() && code[first] == '#')
      while (at < code.size() && code[at] != '\n') code[at++] = ' ';
  std::vector<Declared> found;
  std::vector<std::string> spaces{""};  // open namespaces by their full names
  std::size_t other_braces = 0, start = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (std::string_view(";{}").find(code[i]) == std::string_view::npos) continue;
    const std::string head = trimmed(code.substr(start, i - start));
    if (other_braces == 0 && code[i] != '}' && !head.empty())
      found.push_back({spaces.back(), head, code[i], code.find_first_not_of(" \t\n", start)});
    start = i + 1;
    std::smatch match;
    if (code[i] == '{' && other_braces == 0 && std::regex_match(head, match, opened)) {
      spaces.push_back(spaces.back() + (spaces.back().empty() ? "" : "::") + match[1].str());
    } else if (code[i] == '{') {
      ++other_braces;
    } else if (code[i] == '}' && other_braces > 0) {
      --other_braces;
    } else if (code[i] == '}' && spaces.size() > 1) {
      spaces.pop_back();
    }
  }
  return found;
}

const char* const kInternal = "aberfit::internal";

// Returns the problem of a declaration in a header of src/<room>; empty if there is none.
std::string against_private(const Declared& declared) {
  static const std::regex part(R"((?:struct|class)\s+\w+(?:::\w+)+[^]*)");
  static const std::regex opened(R"((?:inline\s+)?namespace\b[^]*)");
  if (std::regex_match(declared.head, opened)) {
    static const std::set<std::string> allowed = {"namespace aberfit", "namespace aberfit::internal"};
    const bool nested = declared.space == "aberfit" && declared.head == "namespace internal";
    return nested || (declared.space.empty() && allowed.contains(declared.head))
               ? ""
               : "opens another namespace than aberfit::internal";
  }
  const bool part_of_public = declared.space == "aberfit" && std::regex_match(declared.head, part);
  return declared.space == kInternal || part_of_public ? "" : "belongs to one room, into aberfit::internal";
}

// Returns whether a place in a class is in its private part.
bool is_private(const std::string& code, std::size_t at) {
  static const std::regex change(R"(\b(?:public|private|protected):|\n\};)");
  std::string last;
  const auto here = code.begin() + std::ptrdiff_t(at);
  for (std::sregex_iterator it(code.begin(), here, change), end; it != end; ++it) last = it->str();
  return last == "private:";
}

}  // namespace

const std::vector<std::string>& rooms() {
  static const std::vector<std::string> names = {"core",    "scene", "measured", "roughness", "spectrum",
                                                 "terms",   "trace", "focus",    "waves",     "theory",
                                                 "forward", "fit",   "method",   "chart",     "specify",
                                                 "report",  "study", "cases",    "commands",  "python"};
  return names;
}

std::vector<std::string> violations(const fs::path& root, const fs::path& file, const std::string& text) {
  const std::optional<std::string> room = room_of(file);
  if (!room) return {file.string() + " lies in no room"};
  // A kernel body that is included through a macro counts where the macro is defined.
  static const std::regex quoted(
      R"re(^\s*#\s*(?:include\s*|define\s+\w+\s+)"([^"]+\.(?:h|hpp|inc|cpp))".*)re");
  static const std::regex angled(R"(^\s*#\s*include\s*<([^>]+)>.*)");
  static const std::regex macro(R"(^\s*#\s*include\s+[A-Z_]+\s*$)");
  static const std::regex any(R"(^\s*#\s*include.*)");
  std::vector<std::string> found;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    std::string problem;
    if (std::regex_match(line, match, quoted)) {
      problem = against_quoted(root, file, *room, match[1]);
    } else if (std::regex_match(line, match, angled)) {
      problem = against_angled(file, *room, match[1]);
    } else if (std::regex_match(line, any) && !std::regex_match(line, macro)) {
      problem = "is an #include that cannot be read";
    }
    if (!problem.empty())
      found.push_back(file.string() + ":" + std::to_string(number) + ": " + line + ": " + problem);
  }
  return found;
}

std::vector<std::string> missing_from_umbrella(const std::vector<fs::path>& files, const std::string& text) {
  const auto at = [&](const fs::path& header) {
    return text.find("#include \"" + header.lexically_relative("include").generic_string() + "\"\n");
  };
  std::vector<std::string> found;
  std::map<std::string, std::size_t> last;  // place of a room's last header
  for (const fs::path& file : files) {
    if (file.extension() != ".h" || *file.begin() != "include") continue;
    const std::string room = room_of(file).value_or("");
    if (room == kUmbrella) continue;
    if (at(file) == std::string::npos)
      found.push_back(file.string() + " is missing");
    else
      last[room] = std::max(last[room], at(file));
  }
  std::size_t before = 0;
  for (const std::string& room : rooms()) {
    if (last.contains(room) && last[room] < before) found.push_back(room + " comes too early");
    before = std::max(before, last[room]);
  }
  return found;
}

std::vector<std::string> long_functions(const fs::path& file, const std::string& text) {
  const std::vector<std::string> code = lines_of(code_of(text));
  std::vector<Extent> functions = functions_at(code, 0, {});
  const std::vector<Extent> members = functions_at(code, 2, functions);
  functions.insert(functions.end(), members.begin(), members.end());
  std::vector<std::string> found;
  for (const Extent& f : functions)
    if (const std::size_t length = f.last - f.first + 1; length > kLongestFunction)
      found.push_back(file.string() + ":" + std::to_string(f.first + 1) + ": " +
                      trimmed(lines_of(text)[f.first]) + ": has " + std::to_string(length) +
                      " lines, more than " + std::to_string(kLongestFunction));
  return found;
}

std::vector<std::string> large_rooms(const std::map<fs::path, std::size_t>& lines) {
  std::map<std::string, std::size_t> by_room;
  std::size_t all = 0;
  for (const auto& [file, count] : lines) {
    by_room[room_of(file).value_or(file.string())] += count;
    all += count;
  }
  std::vector<std::string> found;
  for (const auto& [room, count] : by_room)
    if (double(count) > kLargestShare * double(all))
      found.push_back(room + " holds " + std::to_string(count) + " of " + std::to_string(all) + " lines");
  return found;
}

std::vector<std::string> changed_studies(const fs::path& file, const std::string& text) {
  static const std::set<std::string> bound = {"chart", "commands", kProgram};
  if (!bound.contains(room_of(file).value_or(""))) return {};
  static const std::regex type(R"((?:aberfit::)?\b(?:Study|Task)\b)");
  static const std::vector<std::pair<std::regex, std::string>> others = {
      {std::regex(R"(\bconst_cast\b)"), "takes const away"},
      {std::regex(R"(\bauto\s+\w+\s*[=({]\s*\*?(?:\w+(?:\.|->))*(?:study|task)\s*[;)}])"), "is a copy"},
      {std::regex(R"((?:^|[;{}()])\s*(?:study|task)\s*=(?!=))"), "assigns"},
      {std::regex(R"(\b(?:study|task)\s*(?:\.|->)\s*\w+(?:\s*(?:\.|->)\s*\w+|\[[^\]\n]*\])*\s*)"
                  R"((?:=(?!=)|[-+*/%|&^]=|\+\+|--))"),
       "assigns"},
      {std::regex(R"((?:\+\+|--)\s*(?:study|task)\s*(?:\.|->))"), "assigns"},
  };
  const std::string code = code_of(text);
  std::vector<std::string> found;
  const std::sregex_iterator end;
  for (std::sregex_iterator it(code.begin(), code.end(), type); it != end; ++it) {
    const auto at = std::size_t(it->position()), behind = at + std::size_t(it->length());
    const std::size_t statement = std::min(code.find_last_of(";{}", at) + 1, at);
    const std::string after = trimmed(code.substr(behind, code.find_first_of(";{}", behind) - behind + 1));
    const std::string problem = against_mention(trimmed(code.substr(statement, at - statement)), after);
    if (!problem.empty()) found.push_back(breach(file, text, at, problem));
  }
  for (const auto& [pattern, problem] : others)
    for (std::sregex_iterator it(code.begin(), code.end(), pattern); it != end; ++it) {
      const std::size_t last = std::size_t(it->position() + it->length()) - 1;
      found.push_back(breach(file, text, last, problem));
    }
  return found;
}

std::vector<std::string> leaked_names(const fs::path& file, const std::string& text) {
  if (file.extension() != ".h") return {};
  static const std::regex opens(R"(\busing\s+namespace\b)");
  static const std::regex forward(R"((?:struct|class)\s+(\w+))");
  static const std::regex mention(R"((\w+::)?\binternal::(\w+))");
  const std::string code = code_of(text);
  const bool is_public = *file.begin() == "include";
  std::vector<std::string> found;
  std::set<std::string> promised;  // classes that the header says are internal
  const std::sregex_iterator end;
  for (std::sregex_iterator it(code.begin(), code.end(), opens); it != end; ++it)
    found.push_back(breach(file, text, std::size_t(it->position()), "opens a namespace to who includes it"));
  for (const Declared& declared : declarations(code)) {
    std::smatch match;
    std::string problem;
    if (!is_public) {
      problem = against_private(declared);
    } else if (declared.space == kInternal) {
      const bool only_named = declared.end == ';' && std::regex_match(declared.head, match, forward);
      if (only_named) promised.insert(match[1]);
      if (!only_named) problem = "is internal, in a public header";
    }
    if (!problem.empty()) found.push_back(breach(file, text, declared.at, problem));
  }
  if (!is_public) return found;
  for (std::sregex_iterator it(code.begin(), code.end(), mention); it != end; ++it) {
    if ((*it)[1].matched && (*it)[1] != "aberfit::") continue;  // of a library
    const auto at = std::size_t(it->position());
    if (!promised.contains((*it)[2])) found.push_back(breach(file, text, at, "is declared elsewhere"));
    if (!is_private(code, at)) found.push_back(breach(file, text, at, "is internal, for everyone to see"));
  }
  return found;
}

std::vector<std::string> warning_codes(const std::string& text) {
  static const std::string word = R"re("([a-z0-9]+(?:-[a-z0-9]+)+)")re";
  static const std::regex given(
      R"re((?:\bpush_back\s*\(|\breturn\s*\{|\bwarning_?\s*=)\s*\{\s*(?:[^"?:;{}]*\?\s*)re" + word +
      R"re(\s*:\s*)?)re" + word + R"re(\s*,)re");
  std::string code = text;
  const std::string comments = comments_of(text);
  for (std::size_t i = 0; i < code.size(); ++i)
    if (comments[i] != ' ') code[i] = comments[i] == '\n' ? '\n' : ' ';
  std::vector<std::string> found;
  const std::sregex_iterator end;
  for (std::sregex_iterator it(code.begin(), code.end(), given); it != end; ++it)
    for (const std::size_t group : {1, 2})
      if ((*it)[group].matched) found.push_back((*it)[group]);
  return found;
}

std::string comments_of(const std::string& text) { return only(Part::kComment, text); }

std::vector<std::string> out_of_place(const std::vector<std::string>& names) {
  static const std::set<std::string> allowed = {
      "src", "include", "fits", "tests", "examples", "CMakeLists.txt", "README.md", "CMakePresets.json"};
  std::vector<std::string> found;
  for (const std::string& name : names)
    if (!allowed.contains(name) && !name.starts_with(".")) found.push_back(name);
  return found;
}

}  // namespace aberfit::test
