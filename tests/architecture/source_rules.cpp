#include "source_rules.h"

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

const char* const kProgram = "main.cpp";  // a room of its own, above all others

// Where each outside library may appear, by the beginning of what is included (DESIGN, the table of rooms).
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
      {"boost/math/", {"core", "roughness", "spectrum", "terms", "theory", "fit", "equivalence"}},
      {"boost/version.hpp", {"report"}},  // a number for the provenance, no code
      {"fftw3.h", {"roughness", "terms", "waves"}},
      {"fitsio.h", {"measured"}},
      {"ceres/", {"spectrum", "fit"}},
      {"nlohmann/", {"measured", "report", "study", "chart", "commands", kProgram}},  // DABAM metadata, results, studies,
      {"CLI/", {kProgram}},
      // The operating system: processes and files of gnuplot and the reports, the terminal of the program.
      {"unistd.h", {"report", kProgram}},
      {"fcntl.h", {"report"}},
      {"sys/", {"report"}},
  };
  return table;
}

// Libraries whose headers the installed package promises to find for its user.
const std::set<std::string> kPublicLibraries = {"Eigen/", "nlohmann/", "fmt/"};

// Room of a path below the root: the folder under include/aberfit or src.
std::optional<std::string> room_of(const fs::path& file) {
  std::vector<std::string> parts;
  for (const fs::path& part : file.lexically_normal()) parts.push_back(part.string());
  if (parts.size() == 2 && parts[0] == "src" && parts[1] == kProgram) return kProgram;
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
    if (file.string().starts_with("include") && !kPublicLibraries.contains(library))
      return "is a private dependency, in a public header";
    return "";
  }
  // Headers of the standard library have neither folder nor suffix.
  if (included.find_first_of("./") != std::string::npos) return "belongs to no library that DESIGN names";
  return "";
}

}  // namespace

const std::vector<std::string>& rooms() {
  static const std::vector<std::string> names = {
      "core",   "scene",   "measured", "roughness",   "spectrum", "terms", "trace",  "focus", "waves",
      "theory", "forward", "fit",      "equivalence", "report",   "study", "method", "chart", "commands"};
  return names;
}

std::vector<std::string> violations(const fs::path& root, const fs::path& file, const std::string& text) {
  const std::optional<std::string> room = room_of(file);
  if (!room) return {file.string() + " lies in no room"};
  // A kernel body that is included through a macro counts where the macro gets its value.
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

std::vector<std::string> out_of_place(const std::vector<std::string>& names) {
  static const std::set<std::string> allowed = {
      "src", "include", "fits", "tests", "examples", "CMakeLists.txt", "README.md", "CMakePresets.json"};
  std::vector<std::string> found;
  for (const std::string& name : names)
    if (!allowed.contains(name) && !name.starts_with(".")) found.push_back(name);
  return found;
}

}  // namespace aberfit::test
