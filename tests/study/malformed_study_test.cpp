#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "run_program.h"
#include "scratch_folder.h"
#include "study_texts.h"

namespace aberfit {
namespace {

using test::MalformedStudy;
using test::run_program;
using test::ScratchFolder;

// The deep study stops at the 64th level; the table has the beginning of its pointer.
void expect_pointer(const MalformedStudy& bad, const std::string& pointer) {
  if (bad.name == "TooDeep")
    EXPECT_TRUE(pointer.starts_with(bad.pointer)) << pointer;
  else
    EXPECT_EQ(pointer, bad.pointer);
}

TEST(MalformedStudy, IsRefusedWithPointerFoundAndAllowed) {
  const ScratchFolder folder;
  folder.write_data();
  const std::string path = folder.file("study.json");
  std::set<std::string> names;
  for (const MalformedStudy& bad : test::malformed_studies()) {
    SCOPED_TRACE(bad.name);
    EXPECT_TRUE(names.insert(bad.name).second);
    try {
      parse_study(bad.text, path);
      ADD_FAILURE() << "was read";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path);
      expect_pointer(bad, error.pointer());
      EXPECT_NE(std::string(error.what()).find(bad.fragment), std::string::npos) << error.what();
      EXPECT_FALSE(error.found().empty());
      EXPECT_FALSE(error.allowed().empty());
    }
  }
  EXPECT_GE(names.size(), 45u);
}

// There is no guess for a word that resembles none, or for a right word that occurs twice.
TEST(MalformedStudy, GuessesOnlyWhatIsNear) {
  for (const auto& [pointer, value] :
       {std::pair("/aperture/shape", R"("dodecahedron")"), std::pair("/aperture/shape", "7"),
        std::pair("/output/arrays", R"("hdf5")"), std::pair("/output/export", R"(["csv", "csv"])")}) {
    try {
      parse_study(test::changed(pointer, value), "study.json");
      ADD_FAILURE() << value << " was read";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("did you mean"), std::string::npos) << error.what();
    }
  }
}

TEST(MalformedStudy, ThatDoesNotExistIsAnInputError) {
  const ScratchFolder folder;
  for (const std::string& path : {folder.file("no-such-study.json"), folder.file(".")}) {
    try {
      read_study(path);
      ADD_FAILURE() << path << " was read";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path);
    }
  }
}

// Every malformed study is given to another command. Only the message may be printed, and nothing written.
TEST(Program, RefusesMalformedStudiesWithExitCode2AndWritesNothing) {
  ASSERT_TRUE(std::filesystem::exists(ABERFIT_PROGRAM)) << "build the program first: " ABERFIT_PROGRAM;
  const ScratchFolder folder;
  folder.write_data();
  const std::vector<std::string> commands = {"fit bad.json -o results", "verify bad.json -o results",
                                             "fit bad.json --json", "trace bad.json",
                                             "check bad.json --json"};
  std::size_t k = 0;
  for (const MalformedStudy& bad : test::malformed_studies()) {
    const std::string& command = commands[k++ % commands.size()];
    SCOPED_TRACE(bad.name + ": " + command);
    folder.write("bad.json", bad.text);
    EXPECT_EQ(run_program(folder, command), 2);
    EXPECT_EQ(test::read_file(folder.file("stdout.txt")), "");
    const std::string message = test::read_file(folder.file("stderr.txt"));
    EXPECT_NE(message.find("bad.json"), std::string::npos) << message;
    EXPECT_NE(message.find(bad.pointer), std::string::npos) << message;
    EXPECT_NE(message.find(bad.fragment), std::string::npos) << message;
    std::set<std::string> present;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
      present.insert(entry.path().filename());
    EXPECT_EQ(present,
              (std::set<std::string>{"bad.json", "psd.csv", "stderr.txt", "stdout.txt", "words.csv"}));
  }
}

TEST(Program, RefusesWrongUsageWithExitCode2) {
  ASSERT_TRUE(std::filesystem::exists(ABERFIT_PROGRAM)) << "build the program first: " ABERFIT_PROGRAM;
  const ScratchFolder folder;
  folder.write("good.json", test::kMinimalStudy);
  for (const char* arguments :
       {"", "fit", "fly good.json", "fit good.json --theads 2", "fit good.json --threads 0",
        "fit good.json --threads many", "fit no-such-study.json", "fit .", "check good.json -o results",
        "fit good.json -o good.json", "fit good.json other.json"}) {
    SCOPED_TRACE(arguments);
    EXPECT_EQ(run_program(folder, arguments), 2);
    EXPECT_EQ(test::read_file(folder.file("stdout.txt")), "");
    EXPECT_NE(test::read_file(folder.file("stderr.txt")), "");
  }
  EXPECT_EQ(test::read_file(folder.file("good.json")), test::kMinimalStudy);
}

TEST(Program, TellsItsVersionHelpAndSchemaOnStandardOutput) {
  ASSERT_TRUE(std::filesystem::exists(ABERFIT_PROGRAM)) << "build the program first: " ABERFIT_PROGRAM;
  const ScratchFolder folder;
  EXPECT_EQ(run_program(folder, "--version"), 0);
  EXPECT_TRUE(test::read_file(folder.file("stdout.txt")).starts_with("aberfit "));
  EXPECT_EQ(run_program(folder, "--help"), 0);
  for (const char* command : {"fit", "verify", "trace", "check", "schema"})
    EXPECT_NE(test::read_file(folder.file("stdout.txt")).find(command), std::string::npos);
  EXPECT_EQ(run_program(folder, "schema"), 0);
  EXPECT_EQ(nlohmann::ordered_json::parse(test::read_file(folder.file("stdout.txt"))), study_schema());
  EXPECT_EQ(test::read_file(folder.file("stderr.txt")), "");
}

}  // namespace
}  // namespace aberfit
