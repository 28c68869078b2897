// Results stay. Whatever commands use one folder, and whoever has files in it, a command replaces only what
// the same command has left there.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using test::read_file;
using test::ScratchFolder;

constexpr const char* kStudy = R"({"aberfit": 1, "title": "small",
  "mirror": {"focal_length": 2.8}, "aperture": {"shape": "circle", "diameter": 0.4},
  "light": {"wavelength": 632.8e-9},
  "roughness": {"psd": {"model": "uniform", "rms": 100e-9, "f_min": 2.5, "f_max": 6}},
  "target": {"theory": "geometric", "statistics": {"ee50": {}}}, "terms": {"zernike": {"n_max": 6}},
  "trace": {"rays": 4096}, "verify": {"draws": 16},
  "solve": {"for": ["/roughness/psd/rms"], "so_that": {"rms_slope": "<= 2 urad"}},
  "vary": {"over": {"/roughness/psd/rms": ["50 nm", "100 nm"]}}})";

const std::map<std::string, std::string> kCommands = {
    {"fit", "fit study.json --pictures none --quiet"},
    {"solve", "solve study.json --pictures none --quiet"},
    {"verify", "verify study.json --pictures none --quiet"},
    {"sweep", "sweep study.json --pictures none --quiet"},
    {"trace", "trace study.json --quiet --arrays csv"},
    {"check", "check study.json --quiet --arrays npz"},
    {"psd", "psd profile.txt --pictures none --quiet --quantity height --x-unit m --value-unit m"}};

// Every file below a folder, hidden ones too, with its bytes; links and folders by their kind.
std::map<std::string, std::string> bytes_below(const std::string& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_symlink())
      all[name] = "link to " + fs::read_symlink(entry.path()).string();
    else if (entry.is_directory())
      all[name] = "a folder";
    else
      all[name] = read_file(entry.path().string());
  }
  return all;
}

class ResultsStay : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    folder_->write("study.json", kStudy);
    std::string profile;
    for (int k = 0; k < 400; ++k)
      profile += std::to_string(1e-3 * k) + " " + std::to_string(double(k * k % 97) / 97) + "\n";
    folder_->write("profile.txt", profile);
    for (const auto& [name, command] : kCommands)
      ASSERT_LE(run(command + " -o whole/" + name), 1) << name << err();
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static int run(const std::string& arguments) { return test::run_program(*folder_, arguments); }
  static std::string err() { return read_file(folder_->file("stderr.txt")); }
  static std::string file(const std::string& name) { return folder_->file(name); }

  // A folder with results of a command and with files of others.
  static std::string folder_of(const std::string& command, const std::string& name) {
    fs::create_directories(fs::path(file(name)).parent_path());
    fs::copy(file("whole/" + command), file(name), fs::copy_options::recursive);
    folder_->write(name + "/notes.txt", "mine");
    fs::create_directories(file(name + "/plots/mine"));
    folder_->write(name + "/plots/compared.png", "mine");
    folder_->write(name + "/plots/mine/study.json", "mine");
    fs::create_symlink("notes.txt", file(name + "/linked"));
    return name;
  }

  static std::unique_ptr<ScratchFolder> folder_;
};
std::unique_ptr<ScratchFolder> ResultsStay::folder_;

TEST_F(ResultsStay, InEveryOrderOfTwoCommandsInOneFolder) {
  int orders = 0;
  for (const auto& [first, ignored] : kCommands)
    for (const auto& [second, command] : kCommands) {
      if (first == second) continue;
      ++orders;
      SCOPED_TRACE(first + ", " + second);
      const std::string folder = folder_of(first, "orders/" + first + "-" + second);
      const auto before = bytes_below(file(folder));
      EXPECT_EQ(run(command + " -o " + folder), 2);
      EXPECT_NE(err().find("of `aberfit " + first + "`"), std::string::npos) << err();
      EXPECT_NE(err().find("--force"), std::string::npos) << err();
      EXPECT_EQ(bytes_below(file(folder)), before);
    }
  EXPECT_EQ(orders, 42);
  EXPECT_EQ(std::distance(fs::directory_iterator(file("orders")), {}), orders) << "something is left beside";
}

TEST_F(ResultsStay, BesideThoseOfAnotherRunOfTheSameCommand) {
  for (const auto& [name, command] : kCommands) {
    SCOPED_TRACE(name);
    const std::string folder = folder_of(name, "again/" + name);
    EXPECT_LE(run(command + " -o " + folder), 1) << err();
    for (const auto& [mine, bytes] : bytes_below(file(folder)))
      if (mine.find("mine") != std::string::npos || mine == "notes.txt" || mine == "plots/compared.png") {
        EXPECT_TRUE(bytes == "mine" || bytes == "a folder") << mine;
      }
    EXPECT_EQ(fs::read_symlink(file(folder + "/linked")), "notes.txt");
    EXPECT_TRUE(fs::exists(file(folder + "/plots/mine/study.json")));
  }
}

TEST_F(ResultsStay, InAFolderForEachCommandWhereNoneIsNamed) {
  for (const auto& [name, command] : kCommands) EXPECT_LE(run(command), 1) << err();
  for (const auto& [name, command] : kCommands) {
    const std::string study =
        name == "psd" ? "profile" : fs::path(file("")).parent_path().filename().string();
    EXPECT_TRUE(fs::exists(file("out/" + study + "/" + name + "/summary.txt"))) << name;
  }
}

// A file of the user's, a changed result, a link or a folder stands where a result would go.
TEST_F(ResultsStay, WhereAFileIsInTheWayOfAResult) {
  const auto refuses = [&](const std::string& command, const std::string& folder, const std::string& name) {
    const auto before = bytes_below(file(folder));
    EXPECT_EQ(run(kCommands.at(command) + " -o " + folder), 2) << name;
    EXPECT_NE(err().find(name), std::string::npos) << err();
    EXPECT_EQ(bytes_below(file(folder)), before) << name;
  };
  for (const char* name : {"summary.txt", "coefficients.csv", "result.json"}) {
    const std::string folder = std::string("way/user-") + name;
    fs::create_directories(file(folder));
    folder_->write(folder + "/" + name, "mine");
    refuses("fit", folder, name);
  }
  const std::string changed = folder_of("fit", "way/changed");
  folder_->write(changed + "/coefficients.csv", read_file(file(changed + "/coefficients.csv")) + "# mine\n");
  refuses("fit", changed, "coefficients.csv");
  fs::create_directories(file("way/link"));
  fs::create_symlink("../../study.json", file("way/link/result.json"));
  refuses("verify", "way/link", "result.json");
  fs::create_directories(file("way/folder/result.json"));
  refuses("solve", "way/folder", "result.json");
  fs::create_directories(file("way/sweep/cases"));
  folder_->write("way/sweep/cases/worker-0001.jsonl", "my workers, no end of line");
  refuses("sweep", "way/sweep", "worker-0001.jsonl");
  fs::create_directories(file("way/arrays"));
  folder_->write("way/arrays/arrays.npz", "mine");
  refuses("check", "way/arrays", "arrays.npz");
}

TEST_F(ResultsStay, ButForWhatIsForcedWhichIsSaid) {
  const std::string folder = folder_of("fit", "forced");
  const auto before = bytes_below(file(folder));
  std::string loud = kCommands.at("solve");
  loud.replace(loud.find(" --quiet"), 8, " --force");
  EXPECT_EQ(run(loud + " -o " + folder), 0) << err();
  EXPECT_NE(err().find("replaced in forced: report.html, result.json, summary.txt of `aberfit fit`"),
            std::string::npos)
      << err();
  const auto after = bytes_below(file(folder));
  for (const auto& [name, bytes] : before)
    if (name != "report.html" && name != "result.json" && name != "summary.txt" && name != ".aberfit-files") {
      EXPECT_EQ(after.at(name), bytes) << name;
    }
  EXPECT_EQ(ordered_json::parse(after.at("result.json"))["status"], "solved");
}

// A sweep continues in its own folder, where it finds its records.
TEST_F(ResultsStay, AndASweepGoesOnFromItsRecords) {
  fs::create_directories(file("resumed"));
  fs::copy(file("whole/sweep/cases"), file("resumed/cases"), fs::copy_options::recursive);
  folder_->write("resumed/notes.txt", "mine");
  const auto before = bytes_below(file("resumed/cases"));
  EXPECT_EQ(run(kCommands.at("sweep") + " -o resumed"), 0) << err();
  EXPECT_EQ(bytes_below(file("resumed/cases")), before);  // nothing was run again
  EXPECT_EQ(read_file(file("resumed/cases.csv")), read_file(file("whole/sweep/cases.csv")));
  EXPECT_EQ(read_file(file("resumed/notes.txt")), "mine");
}

}  // namespace
}  // namespace aberfit
