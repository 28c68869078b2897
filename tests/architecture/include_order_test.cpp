// The map of the repository, kept true: which room includes which, which library lives where, what lies at
// the top.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "source_rules.h"

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = ABERFIT_SOURCE_DIR;

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Sources and headers of the library and the program, as paths below the root.
std::vector<fs::path> sources() {
  std::vector<fs::path> found;
  for (const char* folder : {"include", "src"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (entry.is_regular_file()) found.push_back(fs::relative(entry.path(), kRoot));
  std::sort(found.begin(), found.end());
  return found;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "  " + line + "\n";
  return text;
}

// What git tracks at the top level; empty where the sources come without git or it will not answer.
std::vector<std::string> tracked_at_top() {
  if (!fs::exists(kRoot / ".git")) return {};
  const std::string command = "git -C '" + kRoot.string() + "' ls-files 2> /dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  char part[4096];
  while (const std::size_t n = std::fread(part, 1, sizeof part, pipe)) text.append(part, n);
  const int status = pclose(pipe);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return {};
  std::set<std::string> names;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    names.insert(line.substr(0, line.find('/')));
    begin = end == std::string::npos ? text.size() : end + 1;
  }
  return {names.begin(), names.end()};
}

std::vector<std::string> present_at_top() {
  const std::set<std::string> ignored_by_git = {"build", "out", "compile_commands.json"};
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const std::string name = entry.path().filename().string();
    if (!ignored_by_git.contains(name)) names.push_back(name);
  }
  return names;
}

TEST(Architecture, EveryIncludeKeepsTheOrderOfTheRoomsAndTheirLibraries) {
  std::set<std::string> seen;
  for (const fs::path& file : sources()) {
    const std::vector<std::string> found = violations(kRoot, file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
    seen.insert(file.parent_path().filename().string());
  }
  // The rooms that exist were read: an empty walk would pass for the wrong reason.
  for (const char* room : {"core", "scene", "measured", "roughness", "spectrum", "terms", "trace", "focus", "waves",
                           "theory", "forward", "fit", "equivalence", "report", "study", "method", "chart",
                           "commands"})
    EXPECT_TRUE(seen.contains(room)) << room;
}

TEST(Architecture, TopLevelHoldsOnlyWhatDesignNames) {
  std::vector<std::string> names = tracked_at_top();
  if (names.empty()) names = present_at_top();
  EXPECT_NE(std::find(names.begin(), names.end(), "CMakeLists.txt"), names.end());
  const std::vector<std::string> found = out_of_place(names);
  EXPECT_TRUE(found.empty()) << joined(found);
}

// The rules themselves: each breach is told, its permitted neighbour is not.
TEST(SourceRules, TellEveryKindOfBreach) {
  struct Case {
    const char* file;
    const char* line;
    const char* problem;  // part of the message; empty: allowed
  };
  const Case cases[] = {
      {"src/trace/a.cpp", "#include \"aberfit/focus/statistic.h\"", "is in focus, above trace"},
      {"src/focus/a.cpp", "#include \"aberfit/trace/ray_bundle.h\"", ""},
      {"src/focus/a.cpp", "#include \"aberfit/focus/statistic.h\"", ""},
      {"include/aberfit/core/a.h", "  #  include \"aberfit/study/study.h\"", "is in study, above core"},
      {"src/main.cpp", "#include \"aberfit/study/study.h\"", ""},
      {"src/study/a.cpp", "#include \"reader.h\"", ""},
      {"src/study/a.cpp", "#include \"../fit/posterior.h\"", "internal to fit"},
      {"src/focus/a.cpp", "#include \"../fit/posterior.h\"", "above focus"},
      {"src/study/a.cpp", "#include \"no_such_file.h\"", "no file"},
      {"src/terms/a.cpp", "#define ABERFIT_KERNEL_BODY \"../fit/posterior.h\"", "above terms"},
      {"src/terms/a.inc", "#include ABERFIT_KERNEL_BODY", ""},
      {"src/fit/a.cpp", "#include <ceres/ceres.h>", ""},
      {"src/spectrum/a.cpp", "#include <ceres/ceres.h>", ""},
      {"src/focus/a.cpp", "#include <ceres/jet.h>", "no place in focus"},
      {"include/aberfit/fit/a.h", "#include <ceres/jet.h>", "private dependency"},
      {"src/study/a.cpp", "#include <nlohmann/json.hpp>", ""},
      {"src/fit/a.cpp", "#include <nlohmann/json.hpp>", "no place in fit"},
      {"include/aberfit/report/a.h", "#include <nlohmann/json.hpp>", ""},
      {"src/main.cpp", "#include <CLI/CLI.hpp>", ""},
      {"src/study/a.cpp", "#include <CLI/CLI.hpp>", "no place in study"},
      {"src/terms/a.cpp", "#include <fftw3.h>", ""},
      {"src/trace/a.cpp", "#include <fftw3.h>", "no place in trace"},
      {"src/core/a.cpp", "#include <Random123/philox.h>", ""},
      {"src/roughness/a.cpp", "#include <Random123/philox.h>", "no place in roughness"},
      {"src/equivalence/a.cpp", "#include <boost/math/distributions/normal.hpp>", ""},
      {"src/focus/a.cpp", "#include <boost/math/distributions/normal.hpp>", "no place in focus"},
      {"src/theory/a.cpp", "#include <boost/multiprecision/cpp_int.hpp>", "no library that DESIGN names"},
      {"src/terms/a.cpp", "#include <omp.h>", "no library that DESIGN names"},
      {"src/core/a.cpp", "#include <math.h>", "no library that DESIGN names"},
      {"src/core/a.cpp", "#include <vector>  // and why", ""},
      {"src/core/a.cpp", "#include SOMETHING(else)", "cannot be read"},
      {"src/attic/a.cpp", "#include <vector>", "lies in no room"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(c.file) + ": " + c.line);
    const std::vector<std::string> found = violations(kRoot, c.file, std::string("int x;\n") + c.line + "\n");
    EXPECT_EQ(found.size(), *c.problem ? 1u : 0u) << joined(found);
    EXPECT_NE(joined(found).find(c.problem), std::string::npos) << joined(found);
  }
  EXPECT_EQ(out_of_place({"src", "README.md", ".ci", ".gitignore", "notes.txt", "data"}),
            (std::vector<std::string>{"notes.txt", "data"}));
}

}  // namespace
}  // namespace aberfit::test
