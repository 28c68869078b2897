// `aberfit new`: the command in the first comment of every starter is run and ends as that comment says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "aberfit/commands/program.h"
#include "aberfit/study/read_study.h"
#include "study/run_program.h"

namespace aberfit {
namespace {

using test::read_file;
using test::run_program;
using test::ScratchFolder;

// A profile of a power law, and a map of three smooth bumps with fine grain, as a user has them.
std::string profile_text() {
  std::string text = "x_mm height_nm\n";
  constexpr int kWaves = 400, kPoints = 2000;
  for (int i = 0; i < kPoints; ++i) {
    const double x = 0.1 * i;  // [mm]
    double height = 0;
    for (int k = 1; k <= kWaves; ++k)  // amplitudes of a 1-D PSD ~ f^-2, phases of the golden angle
      height += 8.0 / k * std::cos(2 * M_PI * k * (x / 200 + 0.38196601 * k));
    text += fmt::format("{:.4f} {:.6f}\n", x, height);
  }
  return text;
}

std::string map_text() {
  std::string text = "# pitch = 0.5 mm\n# unit = nm\n# of: surface\n";
  constexpr int kSide = 96;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const double x = (j - 47.5) / 48, y = (i - 47.5) / 48;
      const double height = 20 * (x * x - y * y) + 15 * x * y * y + 2 * std::sin(19 * x + 23 * y);
      text += fmt::format("{:.5f}{}", height, j + 1 < kSide ? " " : "\n");
    }
  return text;
}

std::string run_new(const ScratchFolder& folder, const std::string& arguments, int expected = 0) {
  EXPECT_EQ(run_program(folder, "new " + arguments), expected) << read_file(folder.file("stderr.txt"));
  return read_file(folder.file(expected == 0 ? "stdout.txt" : "stderr.txt"));
}

// Kind, arguments of `new`, and the command of the comment with its promised word.
struct Promise {
  const char *kind, *file, *command, *word;
  int exit_code;
};
const Promise kPromises[] = {
    {"specification", "", "fit", "EQUIVALENT", 0},      {"profile", "profile.csv", "psd", "converged", 0},
    {"map", "map.txt", "fit", "NOT JUDGED", 0},         {"budget", "", "solve", "SOLVED", 0},
    {"sweep", "", "sweep", "SWEPT: 40 of 40 cases", 0}, {"paper", "", "fit", "EQUIVALENT", 0},
};

TEST(Starters, EndAsTheirFirstCommentPromises) {
  const ScratchFolder folder;
  folder.write("profile.csv", profile_text());
  folder.write("map.txt", map_text());
  std::vector<std::string> kinds;
  for (const Promise& promise : kPromises) {
    SCOPED_TRACE(promise.kind);
    kinds.emplace_back(promise.kind);
    run_new(folder, fmt::format("{} {}", promise.kind, promise.file));
    const std::string study = folder.file(std::string(promise.kind) + ".jsonc"), text = read_file(study);
    const std::string command = fmt::format("//   aberfit {} {}.jsonc", promise.command, promise.kind);
    ASSERT_NE(text.find(command), std::string::npos);
    // The comment must contain the word; a line break counts as a blank.
    const std::string head = std::regex_replace(text.substr(0, text.find("\n{")), std::regex("\n// *"), " ");
    EXPECT_NE(head.find(promise.word), std::string::npos) << head;
    EXPECT_EQ(run_program(folder, fmt::format("{} {}.jsonc --pictures none", promise.command, promise.kind)),
              promise.exit_code)
        << read_file(folder.file("stderr.txt"));
    const std::string said = read_file(folder.file("stdout.txt"));
    EXPECT_NE(said.find(promise.word), std::string::npos) << said;
  }
  EXPECT_EQ(kinds, starter_kinds()) << "every kind has its promise here";
}

// The comments offer further lines. They are valid without their // (and with the comma that a comment asks
// for).
TEST(Starters, OfferLinesThatTheReaderTakes) {
  const ScratchFolder folder;
  folder.write("my_profile.csv", profile_text());
  folder.write("my_map.dat", map_text());
  for (const std::string& kind : starter_kinds()) {
    SCOPED_TRACE(kind);
    run_new(folder, kind);
    std::string text = read_file(folder.file(kind + ".jsonc"));
    const std::size_t body = text.find("\n{");
    text = text.substr(body);
    static const std::regex offered("\n( *)// (\"[^\n]*|  +\"[^\n]*)");
    const std::string opened = std::regex_replace(text, offered, "\n$1$2");
    EXPECT_EQ(opened != text, kind != "sweep") << "all others offer something";
    static const std::regex comment(" *//[^\n]*"), comma("([}\\]\"0-9])(\\s*\n\\s*\")");
    std::string plain = std::regex_replace(opened, comment, "");
    plain = std::regex_replace(plain, comma, "$1,$2");
    const auto json = nlohmann::ordered_json::parse(plain, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << plain;
    folder.write("opened.json", plain);
    EXPECT_NO_THROW(read_study(folder.file("opened.json"))) << plain;
  }
}

TEST(Starters, NeverWriteOverAFileUnlessForced) {
  const ScratchFolder folder;
  folder.write("mine.jsonc", "mine");
  EXPECT_NE(run_new(folder, "budget mine.jsonc", 2).find("already there"), std::string::npos);
  EXPECT_EQ(read_file(folder.file("mine.jsonc")), "mine");
  run_new(folder, "budget mine.jsonc --force");
  EXPECT_NE(read_file(folder.file("mine.jsonc")).find("aberfit solve mine.jsonc"), std::string::npos)
      << "comments name the file as it is called";
}

TEST(Starters, NameTheMeasurementThatTheyAreGiven) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder.file("data"));
  folder.write("data/part \"A\".csv", profile_text());
  run_new(folder, "profile 'data/part \"A\".csv'");
  const std::string study = folder.file("part \"A\".jsonc");
  const Study read = read_study(study);
  EXPECT_EQ(std::get<MeasuredPsd>(read.roughness->model).source.file, "data/part \"A\".csv");
  EXPECT_NE(run_new(folder, "profile none.csv", 2).find("a file that cannot be read"), std::string::npos);
  EXPECT_NE(run_new(folder, "budget 'data/part \"A\".csv'", 2).find(".jsonc"), std::string::npos);
  EXPECT_NE(run_new(folder, "profile mine.json", 2).find(".jsonc"), std::string::npos);
}

TEST(Starters, AreListedWithALineEach) {
  const ScratchFolder folder;
  const std::string list = run_new(folder, "");
  for (const std::string& kind : starter_kinds())
    EXPECT_TRUE(std::regex_search(list, std::regex("\n  " + kind + " +[A-Z][^\n]{20,}"))) << list;
  EXPECT_NE(run_new(folder, "specificaton", 2).find("did you mean \"specification\"?"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
