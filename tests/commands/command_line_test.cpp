// Help, manual page, completions and explained keys, and their layout on a terminal.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "aberfit/specify/budget.h"
#include "study/run_program.h"
#include "study/study_texts.h"

namespace aberfit {
namespace {

using test::read_file;
using test::run_program;
using test::ScratchFolder;

std::string printed(const ScratchFolder& folder, const std::string& arguments, int expected = 0) {
  EXPECT_EQ(run_program(folder, arguments), expected) << arguments << "\n"
                                                      << read_file(folder.file("stderr.txt"));
  return read_file(folder.file(expected == 0 ? "stdout.txt" : "stderr.txt"));
}

// The options and commands that the source of the command line declares, found without the parser.
std::set<std::string> declared(const char* expression) {
  const std::string source = read_file(ABERFIT_SOURCE_DIR "/src/command_line.cpp");
  std::set<std::string> names;
  const std::regex pattern(expression);
  for (std::sregex_iterator it(source.begin(), source.end(), pattern), end; it != end; ++it)
    names.insert((*it)[1]);
  return names;
}
std::set<std::string> declared_options() { return declared(R"re([",](--[a-z][a-z-]+)",)re"); }
std::set<std::string> declared_commands() {
  std::set<std::string> names = declared(R"re(add_(?:study_command|subcommand)\(\s*(?:app, )?"([a-z]+)",)re");
  names.erase("manual");
  return names;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
  return longest;
}

// Runs the program on a pseudo-terminal with this many columns; returns what it writes to either stream.
std::string on_terminal(const ScratchFolder& folder, const std::string& arguments,
                        const std::string& environment, unsigned short columns = 100) {
  const winsize size{40, columns, 0, 0};
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
  if (child == 0) {
    const std::string command =
        "cd '" + folder.file("") + "' && " + environment + " '" ABERFIT_PROGRAM "' " + arguments;
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  std::string text;
  char part[4096];
  for (ssize_t n; (n = read(terminal, part, sizeof part)) > 0;) text.append(part, std::size_t(n));
  close(terminal);
  int status = 0;
  waitpid(child, &status, 0);
  return text;
}

TEST(CommandHelp, OfEveryCommandHasItsOptionsItsWordsAndAnExample) {
  const ScratchFolder folder;
  const std::set<std::string> commands = declared_commands();
  EXPECT_GE(commands.size(), 10u);
  std::string all = printed(folder, "--help");
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    EXPECT_NE(all.find("\n  " + command + " "), std::string::npos);
    const std::string help = printed(folder, command + " --help");
    EXPECT_TRUE(std::regex_search(help, std::regex("\nExamples?:\n  aberfit (new|" + command + ")[ \n]")))
        << help;
    EXPECT_LE(longest_line(help), 100u);
    all += help;
  }
  for (const std::string& option : declared_options())
    EXPECT_NE(all.find(option), std::string::npos) << option;
  for (const BudgetKey& key : budget_keys()) {
    const std::string word = key.sample.substr(0, key.sample.find_first_of("0123456789@_"));
    EXPECT_NE(printed(folder, "solve --help").find(word), std::string::npos) << key.sample;
  }
}

TEST(CommandHelp, IsAsWideAsItsTerminal) {
  const ScratchFolder folder;
  const auto paragraphs = [&](const std::string& help) { return help.substr(0, help.find("Examples")); };
  const std::string narrow = paragraphs(printed(folder, "chart --help"));
  EXPECT_LE(longest_line(narrow), 80u);
  EXPECT_GT(longest_line(narrow), 60u);
  setenv("COLUMNS", "50", 1);
  EXPECT_LE(longest_line(paragraphs(printed(folder, "chart --help"))), 50u);
  unsetenv("COLUMNS");
  const std::string wide = paragraphs(on_terminal(folder, "chart --help", "TERM=dumb", 110));
  EXPECT_GT(longest_line(wide), 90u);
  EXPECT_LE(longest_line(wide), 111u) << "with the carriage return of a terminal";
}

TEST(ManualPage, HasEveryCommandAndOptionAndIsWithoutFault) {
  const ScratchFolder folder;
  const std::string page = printed(folder, "manual man");
  folder.write("aberfit.1", page);
  const std::string plain = std::regex_replace(page, std::regex(R"(\\-)"), "-");
  for (const std::string& command : declared_commands())
    EXPECT_NE(plain.find("\n.SS aberfit " + command + "\n"), std::string::npos) << command;
  for (const std::string& option : declared_options())
    EXPECT_TRUE(std::regex_search(plain, std::regex("\n\\.B [^\n]*" + option + "[ \n]"))) << option;
  if (std::system("man --version > /dev/null 2>&1") != 0) return;
  const std::string shown = "man --warnings -E ascii -l '" + folder.file("aberfit.1") + "' > '" +
                            folder.file("shown.txt") + "' 2> '" + folder.file("faults.txt") + "'";
  EXPECT_EQ(std::system(("MANWIDTH=90 " + shown).c_str()), 0);
  EXPECT_EQ(read_file(folder.file("faults.txt")), "");
  EXPECT_NE(read_file(folder.file("shown.txt")).find("--time-limit"), std::string::npos);
}

// The completion is called as bash does it: words in COMP_WORDS, the answer in COMPREPLY.
std::set<std::string> completions(const ScratchFolder& folder, const std::vector<std::string>& typed) {
  std::string list;
  for (const std::string& word : typed) list += " '" + word + "'";
  const std::string script = fmt::format(
      "source completion\ncompopt() {{ :; }}\nCOMP_WORDS=({})\nCOMP_CWORD=$((${{#COMP_WORDS[@]}} - "
      "1))\n_aberfit\n"
      "printf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
      list);
  folder.write("ask.sh", script);
  EXPECT_EQ(std::system(("cd '" + folder.file("") + "' && bash ask.sh > answer.txt").c_str()), 0);
  std::istringstream lines(read_file(folder.file("answer.txt")));
  std::set<std::string> words;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) words.insert(line);
  return words;
}

TEST(ShellCompletion, KnowsEveryCommandOptionAndWord) {
  const ScratchFolder folder;
  folder.write("completion", printed(folder, "manual bash"));
  folder.write("my study.json", "{}");
  std::set<std::string> commands = declared_commands();
  EXPECT_EQ(completions(folder, {"aberfit", ""}), commands);
  EXPECT_EQ(completions(folder, {"aberfit", "so"}), std::set<std::string>{"solve"});
  std::set<std::string> options;
  for (const std::string& command : commands)
    for (const std::string& option : completions(folder, {"aberfit", command, "--"})) options.insert(option);
  for (const std::string& option : declared_options()) EXPECT_TRUE(options.contains(option)) << option;
  EXPECT_TRUE(completions(folder, {"aberfit", "--threads", "2", "fit", "--ar"}).contains("--arrays"));
  EXPECT_FALSE(completions(folder, {"aberfit", "solve", "--ar"}).contains("--arrays"));
  EXPECT_TRUE(completions(folder, {"aberfit", "fit", "--arrays", ""}).contains("npz"));
  EXPECT_TRUE(completions(folder, {"aberfit", "new", "bu"}).contains("budget"));
  EXPECT_TRUE(completions(folder, {"aberfit", "fit", "my"}).contains("my study.json"));
  const std::string fish = printed(folder, "manual fish");
  for (const std::string& command : commands) EXPECT_NE(fish.find(" -a " + command + " "), std::string::npos);
  for (const std::string& option : declared_options())
    EXPECT_NE(fish.find(" -l " + option.substr(2) + " "), std::string::npos) << option;
}

TEST(ExplainedKey, SaysMeaningTypeUnitsRangeDefaultAndExample) {
  const ScratchFolder folder;
  const std::string focal = printed(folder, "schema mirror/focal_length");
  for (const char* word :
       {"paraxial focal length [m]", "nm, um, mm", "above 0", "\"focal_length\": \"2.8 m\"", "required"})
    EXPECT_NE(focal.find(word), std::string::npos) << word << "\n" << focal;
  const std::string margin = printed(folder, "schema equivalence/margin");
  EXPECT_TRUE(std::regex_search(margin, std::regex("default +0\\.01\n"))) << margin;
  const std::string psd = printed(folder, "schema /roughness/psd");
  for (const char* model : {"uniform", "k-correlation", "power-law", "gaussian", "table", "measured", "sum"})
    EXPECT_NE(psd.find(fmt::format("\nkeys of \"{}\"", model)), std::string::npos) << model << "\n" << psd;
  EXPECT_NE(printed(folder, "schema ee73").find("target/statistics/ee50"), std::string::npos)
      << "keys that are data";
  EXPECT_LE(longest_line(psd), 80u);
}

// Every key of the schema can be explained by its path; we try those up to two levels down.
void visit_keys(const nlohmann::ordered_json& node, const std::string& path,
                std::vector<std::string>* paths) {
  if (std::count(path.begin(), path.end(), '/') > 1) return;
  if (node.contains("properties"))
    for (const auto& item : node["properties"].items()) {
      paths->push_back(path + item.key());
      visit_keys(item.value(), path + item.key() + "/", paths);
    }
}

TEST(ExplainedKey, IsEveryKeyOfTheSchema) {
  const ScratchFolder folder;
  const auto schema = nlohmann::ordered_json::parse(printed(folder, "schema"));
  EXPECT_EQ(schema["$id"], "aberfit.schema.json");
  std::vector<std::string> paths;
  visit_keys(schema, "", &paths);
  EXPECT_GT(paths.size(), 50u);
  for (const std::string& path : paths)
    EXPECT_TRUE(printed(folder, "schema '" + path + "'").starts_with(path)) << path;
  const std::string blocks = printed(folder, "schema study");
  for (const auto& item : schema["properties"].items()) EXPECT_NE(blocks.find(item.key()), std::string::npos);
}

TEST(ExplainedKey, ThatIsSeveralIsListedAndThatIsUnknownHasNearOnes) {
  const ScratchFolder folder;
  const std::string several = printed(folder, "schema margin");
  for (const char* path : {"equivalence/margin", "aperture/margin"})
    EXPECT_NE(several.find(path), std::string::npos) << several;
  const std::string unknown = printed(folder, "schema roughnes/psd", 2);
  EXPECT_NE(unknown.find("similar ones: roughness/psd"), std::string::npos) << unknown;
  EXPECT_NE(printed(folder, "schema focal_lenght", 2).find("mirror/focal_length"), std::string::npos);
  EXPECT_NE(printed(folder, "schema annulus").find("* inner_diameter"), std::string::npos);
  // A key of every shape is explained once, with its own keys once.
  const std::string spiders = printed(folder, "schema aperture/spiders");
  EXPECT_NE(spiders.find("of \"circle\", \"annulus\", "), std::string::npos) << spiders;
  for (const char* once : {"vanes from the axis", "* width"})
    EXPECT_EQ(spiders.find(once), spiders.rfind(once)) << spiders;
  EXPECT_NE(printed(folder, "schema xyzzyxyzzy", 2).find("schema study"), std::string::npos);
}

const char* const kEscape = "\x1b[";

TEST(Terminal, HasColourWhereItTakesIt) {
  const ScratchFolder folder;
  folder.write(
      "study.json",
      test::changed("/solve", R"({"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}})"));
  const std::string solve = "solve study.json --pictures none";
  EXPECT_NE(on_terminal(folder, solve, "TERM=xterm").find("\x1b[1;32mSOLVED"), std::string::npos);
  EXPECT_NE(on_terminal(folder, "check none.json", "TERM=xterm").find("\x1b[1;31maberfit:"),
            std::string::npos);
  const std::string plain = on_terminal(folder, solve + " --quiet", "NO_COLOR=1 TERM=xterm");
  EXPECT_EQ(plain.find(kEscape), std::string::npos) << plain;
  for (const std::string& command : {solve, std::string("check none.json"), std::string("--help")}) {
    const std::string dumb = on_terminal(folder, command, "TERM=dumb");
    EXPECT_EQ(dumb.find('\x1b'), std::string::npos) << dumb;
  }
  EXPECT_EQ(printed(folder, solve).find('\x1b'), std::string::npos);
  EXPECT_EQ(on_terminal(folder, solve + " --json --quiet", "TERM=xterm").find('\x1b'), std::string::npos);
}

TEST(TimeLimit, EndsEveryCommandOfAStudyWithExitCode4AndNothingWritten) {
  const ScratchFolder folder;
  folder.write(
      "study.json",
      test::changed("/solve", R"({"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}})"));
  for (const char* command : {"check --arrays npz", "solve", "verify", "chart", "trace --arrays npz"}) {
    SCOPED_TRACE(command);
    const std::string said =
        printed(folder, fmt::format("{} study.json -o out --time-limit '0.001 s'", command), 4);
    EXPECT_NE(said.find("stopped by --time-limit 0.001 s; nothing is written"), std::string::npos) << said;
    EXPECT_FALSE(std::filesystem::exists(folder.file("out/result.json")));
  }
  printed(folder, "solve study.json --pictures none --time-limit '1 h'");
  EXPECT_NE(printed(folder, "check study.json --time-limit 60", 2).find("a positive time with its unit"),
            std::string::npos);
}

TEST(MistypedCommandLine, IsAnsweredWithWhatWasMeant) {
  const ScratchFolder folder;
  for (const auto& [typed, meant] : {std::pair{"sovle x.json", "did you mean \"solve\"?"},
                                     {"budget", "`aberfit new budget`"},
                                     {"help", "`aberfit --help`"},
                                     {"fit x.json --treads 2", "--treads: did you mean --threads?"},
                                     {"fit x.json --out=a", "--out: did you mean --output?"}})
    EXPECT_NE(printed(folder, typed, 2).find(meant), std::string::npos) << typed;
}

TEST(Version, IsThatOfTheChanges) {
  const ScratchFolder folder;
  const std::string changes = read_file(ABERFIT_SOURCE_DIR "/src/CHANGES.md");
  std::smatch newest;
  ASSERT_TRUE(std::regex_search(changes, newest, std::regex("\n## ([0-9.]+)")));
  EXPECT_EQ(printed(folder, "--version"), "aberfit " + newest[1].str() + "\n");
}

}  // namespace
}  // namespace aberfit
