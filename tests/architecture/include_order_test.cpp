// Keeps the rules of the repository: includes between rooms, outside libraries per room, the top level,
// lengths of functions and rooms, where a study may be changed, names that leave their room, and a test for
// every warning.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "source_rules.h"
#include "source_text.h"

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

// Sources and headers of the library and the program, as paths below the root. Pages, scripts of pictures and
// other texts do not count.
std::vector<fs::path> sources() {
  std::vector<fs::path> found;
  for (const char* folder : {"include", "src"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (entry.is_regular_file() &&
          std::set<std::string>{".h", ".cpp", ".inc"}.contains(entry.path().extension().string()))
        found.push_back(fs::relative(entry.path(), kRoot));
  std::sort(found.begin(), found.end());
  return found;
}

// Names that git tracks at the top level; empty if the sources come without git or git fails.
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
  // The existing rooms must be among the files; an empty list would pass wrongly.
  for (const char* room : {"core",    "scene",  "measured", "roughness", "spectrum", "terms",  "trace",
                           "focus",   "waves",  "theory",   "forward",   "fit",      "method", "chart",
                           "specify", "report", "study",    "cases",     "commands", "python"})
    EXPECT_TRUE(seen.contains(room)) << room;
}

TEST(Architecture, OneHeaderIncludesEveryPublicHeaderInTheOrderOfTheRooms) {
  const std::vector<std::string> found =
      missing_from_umbrella(sources(), contents(kRoot / "include/aberfit/aberfit.h"));
  EXPECT_TRUE(found.empty()) << "in include/aberfit/aberfit.h:\n" << joined(found);
}

TEST(Architecture, NoFunctionIsLongerThanEightyLines) {
  for (const fs::path& file : sources()) {
    const std::vector<std::string> found = long_functions(file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
  }
}

// The linker takes two classes of one name for one and keeps the functions of either.
TEST(Architecture, NoTwoHeadersDefineAClassOfOneName) {
  static const std::regex definition(R"((?:^|\n)(?:struct|class) (\w+)\b(?!::)[^;{]*\{)");
  std::map<std::string, std::string> header_of;
  for (const fs::path& file : sources()) {
    if (file.extension() != ".h") continue;
    const std::string text = contents(kRoot / file);
    const bool internal = text.find("namespace aberfit::internal {") != std::string::npos;
    for (std::sregex_iterator it(text.begin(), text.end(), definition), end; it != end; ++it) {
      const auto [known, is_new] =
          header_of.try_emplace((internal ? "internal::" : "") + (*it)[1].str(), file.string());
      EXPECT_TRUE(is_new || known->second == file.string())
          << (*it)[1] << " in " << file.string() << " and in " << known->second;
    }
  }
  EXPECT_GT(header_of.size(), 100u);
}

TEST(Architecture, NoRoomHoldsMoreThanItsShare) {
  std::map<fs::path, std::size_t> lines;
  for (const fs::path& file : sources()) {
    const std::string text = contents(kRoot / file);
    lines[file] = std::size_t(std::count(text.begin(), text.end(), '\n'));
  }
  const std::vector<std::string> found = large_rooms(lines);
  EXPECT_TRUE(found.empty()) << joined(found);
}

TEST(Architecture, ChartsAndCommandsLeaveTheStudyAsItWasRead) {
  for (const fs::path& file : sources()) {
    const std::vector<std::string> found = changed_studies(file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
  }
}

TEST(Architecture, NamesOfOneRoomStayInside) {
  for (const fs::path& file : sources()) {
    const std::vector<std::string> found = leaked_names(file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
  }
}

// Texts of the tests, by the folder below tests/. `fits` includes the expected results of the studies. The
// texts with which the rules below are tested are left out, because they are no test of a warning.
std::map<std::string, std::string> texts_of_tests() {
  std::map<std::string, std::string> texts;
  const auto read = [&](const char* top, const auto& counts) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / top)) {
      const fs::path file = fs::relative(entry.path(), kRoot / top);
      if (entry.is_regular_file() && counts(file))
        texts[top == std::string("fits") ? top : file.begin()->string()] += contents(entry.path());
    }
  };
  read("tests", [](const fs::path& file) {
    const std::string folder = file.begin()->string();
    return (file.extension() == ".cpp" || file.extension() == ".h") && folder != "architecture" &&
           folder != "data";
  });
  read("fits", [](const fs::path& file) { return file.filename() == "expected.json"; });
  return texts;
}

// A test that names a code need not test the warning, but a code that no test names is not tested.
TEST(Architecture, EveryWarningIsNamedByATest) {
  const std::map<std::string, std::string> tests = texts_of_tests();
  EXPECT_TRUE(tests.contains("method") && tests.contains("fits"));
  std::set<std::string> codes;
  for (const fs::path& file : sources()) {
    const bool reports = file.parent_path().filename() == "report";
    for (const std::string& code : warning_codes(contents(kRoot / file))) {
      codes.insert(code);
      // The hand-made results in tests of reports do not count.
      EXPECT_TRUE(std::any_of(tests.begin(), tests.end(),
                              [&](const auto& test) {
                                return (reports || test.first != "report") &&
                                       test.second.find('"' + code + '"') != std::string::npos;
                              }))
          << file.string() << ": no test names the warning " << code;
    }
  }
  EXPECT_GT(codes.size(), 35u);  // sources were read, and warnings found
}

TEST(Architecture, TopLevelHoldsOnlyWhatBelongsThere) {
  std::vector<std::string> names = tracked_at_top();
  if (names.empty()) names = present_at_top();
  EXPECT_NE(std::find(names.begin(), names.end(), "CMakeLists.txt"), names.end());
  const std::vector<std::string> found = out_of_place(names);
  EXPECT_TRUE(found.empty()) << joined(found);
}

// Tests the rules themselves: each breach is reported, its permitted neighbour is not.
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
      {"src/study/a.cpp", "#include \"visitor.h\"", ""},
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
      {"include/aberfit/report/a.h", "#include <nlohmann/json_fwd.hpp>", ""},
      {"include/aberfit/report/a.h", "#include <nlohmann/json.hpp>", "only named in public headers"},
      {"src/main.cpp", "#include <CLI/CLI.hpp>", ""},
      {"src/manual.cpp", "#include \"command_line.h\"", ""},
      {"src/commands/a.cpp", "#include \"../manual.h\"", "above commands"},
      {"src/study/a.cpp", "#include <CLI/CLI.hpp>", "no place in study"},
      {"src/terms/a.cpp", "#include <fftw3.h>", ""},
      {"src/trace/a.cpp", "#include <fftw3.h>", "no place in trace"},
      {"src/core/a.cpp", "#include <Random123/philox.h>", ""},
      {"src/roughness/a.cpp", "#include <Random123/philox.h>", "no place in roughness"},
      {"src/method/a.cpp", "#include <boost/math/distributions/normal.hpp>", ""},
      {"src/focus/a.cpp", "#include <boost/math/distributions/normal.hpp>", "no place in focus"},
      {"src/theory/a.cpp", "#include <boost/multiprecision/cpp_int.hpp>",
       "no library that src/README.md names"},
      {"src/terms/a.cpp", "#include <omp.h>", "no library that src/README.md names"},
      {"src/core/a.cpp", "#include <math.h>", "no library that src/README.md names"},
      {"src/core/a.cpp", "#include <vector>  // and why", ""},
      {"src/core/a.cpp", "#include SOMETHING(else)", "cannot be read"},
      {"include/aberfit/aberfit.h", "#include \"aberfit/commands/run.h\"", ""},
      {"include/aberfit/aberfit.h", "#include <Eigen/Core>", "no place in aberfit.h"},
      {"src/commands/a.cpp", "#include \"aberfit/aberfit.h\"", "is in aberfit.h, above commands"},
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

TEST(SourceRules, TellWarningsFromOtherWords) {
  struct Case {
    const char* line;
    std::vector<std::string> codes;
  };
  const Case cases[] = {
      {"warnings.push_back({\"no-tea\", \"the pot is empty\"});", {"no-tea"}},
      {"result->warnings.push_back(\n    {\"no-tea\",\n     fmt::format(\"{}\", 1)});", {"no-tea"}},
      {"warnings->push_back( { \"no-tea-4-2\", a + b});", {"no-tea-4-2"}},
      {"warnings->push_back(\n    {cold ? \"no-tea\" : \"no-ice\", why});", {"no-tea", "no-ice"}},
      {"*warning_ = {\n  \"no-tea\",\n  \"the pot is empty\"};", {"no-tea"}},
      {"return {{\"no-tea\", \"the pot is empty\"}};", {"no-tea"}},
      {"f({\"a-a\", b}); warnings.push_back({\"no-tea\", c}); g.push_back({\"no-ice\", d});",
       {"no-tea", "no-ice"}},
      {"// warnings.push_back({\"no-tea\", \"the pot is empty\"});", {}},
      {"v.word(fit.prior, {\"near-start\", \"zero-mean\"});", {}},
      {"Family family{\"tea-count\", \"cups\"};", {}},
      {"names.push_back(\"no-tea\");", {}},
      {"warnings.push_back({\"No tea\", \"the pot is empty\"});", {}},
  };
  for (const Case& c : cases) EXPECT_EQ(warning_codes(c.line), c.codes) << c.line;
}

TEST(SourceRules, TellWhatTheUmbrellaHeaderMisses) {
  const std::vector<fs::path> files = {"include/aberfit/aberfit.h", "include/aberfit/core/a.h",
                                       "include/aberfit/core/a.inc", "include/aberfit/fit/b.h",
                                       "src/fit/c.h"};
  const std::string a = "#include \"aberfit/core/a.h\"\n", b = "#include \"aberfit/fit/b.h\"\n";
  EXPECT_TRUE(missing_from_umbrella(files, a + "\n// fit\n" + b).empty());
  EXPECT_EQ(missing_from_umbrella(files, a), std::vector<std::string>{"include/aberfit/fit/b.h is missing"});
  EXPECT_EQ(missing_from_umbrella(files, b + a), std::vector<std::string>{"fit comes too early"});
}

// A function body with this number of lines.
std::string body(std::size_t lines) {
  std::string text;
  for (std::size_t i = 0; i < lines; ++i) text += i % 7 == 3 ? "\n" : "    ++x;  // }\n";
  return text;
}

TEST(SourceRules, TellFunctionsThatAreTooLong) {
  struct Case {
    std::string before, signature, after;  // the lines of the function begin at its signature
    std::size_t own_lines;                 // of the signature and the closing brace
  };
  const Case cases[] = {
      {"int a;\n\n", "int f(int x) {\n", "}\n", 2},
      {"// What it does.\n", "std::vector<int> f(int x,\n                   int y = {}) {\n", "}\n", 3},
      {"namespace {\n", "template <class T>\nint f(T x) {  // {\n", "}\n}\n", 3},
      {"struct S {\n  int a = 0;\n", "  explicit S(int x)\n      : a{x},\n        b(x) {\n", "  }\n};\n", 4},
      {"class S {\n public:\n", "  int f() const {\n", "  }\n};\n", 2},
      {"const char* text = R\"(\n}\n)\";\n", "int f(int x) {\n", "}\n", 2},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.signature);
    const auto with = [&](std::size_t lines) {
      return long_functions("src/fit/a.cpp", c.before + c.signature + body(lines - c.own_lines) + c.after);
    };
    EXPECT_TRUE(with(kLongestFunction).empty()) << joined(with(kLongestFunction));
    const std::vector<std::string> found = with(kLongestFunction + 1);
    ASSERT_EQ(found.size(), 1u) << joined(found);
    const auto line = std::count(c.before.begin(), c.before.end(), '\n') + 1;
    EXPECT_TRUE(found[0].starts_with("src/fit/a.cpp:" + std::to_string(line) + ": ")) << found[0];
    EXPECT_NE(found[0].find("has 81 lines"), std::string::npos) << found[0];
  }
  for (const char* no_function :
       {"namespace a {\n", "struct S : T<decltype(f())> {\n", "const int kTable[] = {\n",
        "const std::map<int, int> kTable(\n    1) = {\n", "enum class E {\n"})
    EXPECT_TRUE(long_functions("src/fit/a.cpp", no_function + body(100) + "}\n").empty()) << no_function;
  // A lambda is part of the function around it, whatever its indentation; later functions are not.
  const std::string with_lambda =
      "void f() {\n  g(\n      1, [&](int x) {\n" + body(70) + "      });\n}\n\nclass S {\n  int f() {\n";
  EXPECT_TRUE(long_functions("src/fit/a.cpp", with_lambda + body(78) + "  }\n};\n").empty());
  EXPECT_EQ(long_functions("src/fit/a.cpp", with_lambda + body(79) + "  }\n};\n").size(), 1u);
}

TEST(SourceRules, TellRoomsThatAreTooLarge) {
  std::map<fs::path, std::size_t> lines = {{"src/main.cpp", 100}};
  for (const char* room : {"core", "scene", "measured", "roughness", "terms", "trace", "focus"})
    lines[fs::path("src") / room / "a.cpp"] = 110;
  lines["include/aberfit/fit/a.h"] = 50;
  lines["src/fit/a.cpp"] = 80;  // together 130 of 1000
  EXPECT_TRUE(large_rooms(lines).empty()) << joined(large_rooms(lines));
  lines["src/fit/b.cpp"] = 23;  // together 153 of 1023
  EXPECT_TRUE(large_rooms(lines).empty()) << joined(large_rooms(lines));
  lines["src/fit/b.cpp"] = 24;  // together 154 of 1024
  EXPECT_EQ(large_rooms(lines), std::vector<std::string>{"fit holds 154 of 1024 lines"});
}

TEST(SourceRules, TellWhereAStudyIsCopiedOrChanged) {
  struct Case {
    const char* line;
    const char* problem;  // empty: allowed
  };
  const Case cases[] = {
      {"const Study study = read_study(path);", ""},
      {"const aberfit::Study study = aberfit::read_study(arguments.file);", ""},
      {"void f(const Study& study, const Task& task);", ""},
      {"void f(Study const& study, const aberfit::Task* task) {", ""},
      {"std::shared_ptr<const Task> task;", ""},
      {"struct Study;", ""},
      {"using aberfit::Task;", ""},
      {"int a = Task::kMost;", ""},
      {"FitTask x; StudyFile y; SubStudy z;", ""},
      {"// Study copy = study;", ""},
      {"option(\"Study file\", \"study.a = 1\");", ""},
      {"if (study.a == 1 && task.b <= 2 && study.c != 3) return;", ""},
      {"const double a = study.b;", ""},
      {"const auto& other = study;", ""},
      {"const auto b = f(study);", ""},
      {"chart.study = resolved(study);", ""},
      {"Study rays = study;", "is not const"},
      {"  aberfit::Study copy;", "is not const"},
      {"Study copy(study);", "is not const"},
      {"Task copy{task};", "is not const"},
      {"void f(int n, Study study);", "is not const"},
      {"void f(Task& task);", "is not const"},
      {"void f(const Groundwork& ground, aberfit::Task* task);", "is not const"},
      {"Study with_rays(const Study& study);", "is not const"},
      {"std::optional<Study> chosen;", "is not const"},
      {"const std::vector<Task> tasks;", "is not const"},
      {"auto x = Study(study);", "is not const"},
      {"struct Own : Task {", "is not const"},
      {"const Study copy = study;", "is a copy"},
      {"const Study copy = Study(study);", "is not const"},
      {"const Task copy(task);", "is a copy"},
      {"const Task copy{task};", "is a copy"},
      {"const Task copy = *pointer;", "is a copy"},
      {"const Task copy = std::move(task);", "is a copy"},
      {"void f(const Study study);", "is a copy"},
      {"auto copy = study;", "is a copy"},
      {"const auto copy = bench.task;", "is a copy"},
      {"auto copy{study};", "is a copy"},
      {"study.trace.pupil.rays = 4096;", "assigns"},
      {"  bench.task.terms[3].n += 2;", "assigns"},
      {"task->fit.seed++;", "assigns"},
      {"--study.a;", "assigns"},
      {"study = read_study(path);", "assigns"},
      {"f(const_cast<Own&>(study));", "takes const away"},
  };
  for (const char* file : {"src/chart/a.cpp", "include/aberfit/chart/a.h", "src/commands/a.cpp",
                           "include/aberfit/commands/a.h", "src/main.cpp"})
    for (const Case& c : cases) {
      SCOPED_TRACE(std::string(file) + ": " + c.line);
      const std::vector<std::string> found =
          changed_studies(file, std::string("int x;\n\n") + c.line + "\nint y;\n");
      EXPECT_EQ(found.empty(), *c.problem == 0) << joined(found);
      for (const std::string& sentence : found)
        EXPECT_TRUE(sentence.starts_with(std::string(file) + ":3: ")) << sentence;
      EXPECT_NE(joined(found).find(c.problem), std::string::npos) << joined(found);
    }
  // The declaration has two lines; rooms below the method may do this.
  EXPECT_EQ(changed_studies("src/main.cpp", "void f(int n,\n       Study study);\n").size(), 1u);
  EXPECT_TRUE(changed_studies("src/main.cpp", "const Study study =\n    read_study(path);\n").empty());
  EXPECT_TRUE(changed_studies("src/study/a.cpp", "Study read_study(const std::string& path);\n").empty());
  EXPECT_TRUE(changed_studies("src/method/a.cpp", "Task copy = task;\ncopy.fit.seed = 1;\n").empty());
}

TEST(SourceRules, TellWhichNamesLeaveTheirRoom) {
  const char* const room = "src/fit/a.h";
  const char* const published = "include/aberfit/fit/a.h";
  const std::string promise = "namespace aberfit {\nnamespace internal {\nclass B;\nstruct C;\n}\n";
  struct Case {
    const char* file;
    std::string text;
    const char* problem;  // empty: allowed
  };
  const Case cases[] = {
      {room, "#pragma once\n#define X {\n// {\nnamespace aberfit::internal {\nint f(int x = 1);\n}\n", ""},
      {room, "namespace aberfit {\nnamespace internal {\nclass A { int f() { return 1; } };\n}\n}\n", ""},
      {room, "namespace aberfit {\nstruct A::Part {\n  int a;\n};\n}\n", ""},
      {room, "namespace aberfit {\nnamespace internal { struct B { int b; }; }\nstruct C {};\n}", "one room"},
      {room, "namespace aberfit {\nclass A;\n}\n", "one room"},
      {room, "namespace aberfit {\ninline double square(double x) { return x * x; }\n}\n", "one room"},
      {room, "namespace aberfit {\ninline constexpr int kMost = 3;\n}\n", "one room"},
      {room, "namespace aberfit::internal {\nint a;\n}\nstruct A {};\n", "one room"},
      {room, "namespace aberfit::detail {\n}\n", "another namespace"},
      {room, "namespace aberfit::internal {\nnamespace {\n}\n}\n", "another namespace"},
      {room, "namespace internal {\n}\n", "another namespace"},
      {room, "namespace aberfit::internal {\ninline void f() {\n  using namespace std;\n}\n}\n",
       "opens a namespace"},
      {"src/fit/a.cpp", "namespace aberfit {\nusing namespace internal;\nint f() { return 1; }\n}\n", ""},
      {published, "namespace aberfit {\nclass A;\nint f();\n}\n", ""},
      {published, "namespace aberfit {\nusing namespace internal;\n}\n", "opens a namespace"},
      {published,
       promise + "class A {\n private:\n  internal::B* b;\n  const aberfit::internal::C& c;\n};\n}", ""},
      {published, promise + "class A {\n public:\n  internal::B* b;\n};\n}", "for everyone to see"},
      {published, promise + "class A {\n private:\n  int a;\n};\ninternal::B& f();\n}",
       "for everyone to see"},
      {published, promise + "class A {\n private:\n  internal::D* d;\n};\n}", "declared elsewhere"},
      {published, promise + "class A {\n  Eigen::internal::D d;\n};\n}", ""},
      {published, "namespace aberfit::internal {\nclass B {};\n}", "in a public header"},
      {published, "namespace aberfit::internal {\nint f();\n}", "in a public header"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const std::vector<std::string> found = leaked_names(c.file, c.text);
    EXPECT_EQ(found.size(), *c.problem ? 1u : 0u) << joined(found);
    EXPECT_NE(joined(found).find(c.problem), std::string::npos) << joined(found);
  }
}

}  // namespace
}  // namespace aberfit::test
