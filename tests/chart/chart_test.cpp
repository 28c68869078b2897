// The chart of the program for a fast study: its files and the physics of its numbers. Times are not judged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::in_seconds;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

const char* const kStudy = R"({
  "aberfit": 1, "title": "small",
  "mirror": { "focal_length": "2.8 m" },
  "aperture": { "shape": "circle", "diameter": "0.4 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "10 /m" } },
  "terms": { "zernike": { "n_max": 15 } },
  "trace": { "rays": 8192 },
  "target": { "theory": "geometric", "statistics": { "ee50": {}, "ee80": {}, "ee90": { "planes": ["0 mm", "1 mm"] }, "ring_fwhm": {}, "scatter_rms": {} } }
})";

// One chart serves every test, because it takes a few seconds.
class ChartRun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    folder_->write("study.json", kStudy);
    exit_code_ = run_program(*folder_, "chart study.json --seconds 3 -o chart");
    err_ = read_file(folder_->file("stderr.txt"));
    table_ = read_file(folder_->file("stdout.txt"));
    const std::string text = read_file(folder_->file("chart/result.json"));
    if (!text.empty()) chart_ = ordered_json::parse(text);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override { ASSERT_EQ(exit_code_, 0) << err_; }

  static std::vector<ordered_json> rows(const std::string& family, const std::string& method = "") {
    std::vector<ordered_json> found;
    for (const ordered_json& row : chart_["rows"])
      if (row["family"] == family && (method.empty() || row["method"] == method)) found.push_back(row);
    return found;
  }
  static double least_error(const std::vector<ordered_json>& rows) {
    double least = INFINITY;
    for (const ordered_json& row : rows)
      if (row["error"].is_number()) least = std::min(least, row["error"].get<double>());
    return least;
  }

  static ScratchFolder* folder_;
  static int exit_code_;
  static std::string err_, table_;
  static ordered_json chart_;
};
ScratchFolder* ChartRun::folder_ = nullptr;
int ChartRun::exit_code_ = -1;
std::string ChartRun::err_, ChartRun::table_;
ordered_json ChartRun::chart_;

// A line of CSV with quoted fields.
std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      all.emplace_back();
    else
      all.back() += c;
  }
  return all;
}

TEST_F(ChartRun, FilesSayTheSame) {
  std::istringstream csv(read_file(folder_->file("chart/chart.csv")));
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  const std::vector<std::string> header = cells(line);
  std::size_t count = 0;
  for (; std::getline(csv, line); ++count) {
    const std::vector<std::string> row = cells(line);
    ASSERT_EQ(row.size(), header.size()) << line;
    ASSERT_LT(count, chart_["rows"].size());
    EXPECT_EQ(row[0], chart_["rows"][count]["family"]);
    EXPECT_EQ(row[1], chart_["rows"][count]["method"]);
  }
  EXPECT_EQ(count, chart_["rows"].size());
  EXPECT_EQ(read_file(folder_->file("chart/summary.txt")), table_);
  EXPECT_GE(chart_["machine"]["threads"], 1);
  EXPECT_EQ(chart_["kind"], "chart");
  EXPECT_TRUE(std::filesystem::exists(folder_->file("chart/plots/chart_models.gp")));
}

TEST_F(ChartRun, EveryFamilyHasRowsOfWhichThoseOnTheFrontierAreNotBeaten) {
  for (const ordered_json& family : chart_["families"]) {
    const std::string name = family["name"];
    SCOPED_TRACE(name);
    const std::vector<ordered_json> all = rows(name);
    if (!family["skipped"].is_null()) {
      EXPECT_EQ(name, "bands");
      EXPECT_TRUE(all.empty());
      continue;
    }
    EXPECT_EQ(all.size(), family["rows"].get<std::size_t>());
    EXPECT_FALSE(all.empty());
    int defaults = 0, frontier = 0;
    for (const ordered_json& row : all) {
      defaults += row["is_default"].get<bool>();
      frontier += row["on_frontier"].get<bool>();
      if (row["is_cheapest_within_tolerance"].get<bool>()) {
        EXPECT_LE(row["error"], family["tolerance"]);
        // Excused if a row beats it whose reference is not known well enough, as on a busy machine.
        const bool excused = std::any_of(all.begin(), all.end(), [&](const ordered_json& other) {
          return other["error"].is_number() && other["seconds"].is_number() &&
                 other["error"] <= row["error"] && other["seconds"] <= row["seconds"] &&
                 other["error_of_reference"] > family["tolerance"];
        });
        EXPECT_TRUE(row["on_frontier"].get<bool>() || excused);
      }
      if (!row["error"].is_number() || !row["seconds"].is_number()) continue;
      EXPECT_GE(row["error"], 0.0);
      EXPECT_LE(row["seconds_low"], row["seconds"]);
      EXPECT_LE(row["seconds"], row["seconds_high"]);
      for (const ordered_json& other : all)
        if (row["on_frontier"].get<bool>() && other["error"].is_number() && other["seconds"].is_number()) {
          EXPECT_FALSE(other["error"] < row["error"] && other["seconds"] < row["seconds"]);
        }
    }
    EXPECT_GE(frontier, 1);
    EXPECT_EQ(defaults, 1);
  }
}

TEST_F(ChartRun, FinerGridsMissLessAndRaysMissWhatDiffractionAdds) {
  const std::vector<ordered_json> waves = rows("models", "waves"), rays = rows("models", "rays");
  ASSERT_GE(waves.size(), 3u);
  ASSERT_GE(rays.size(), 2u);
  // The coarsest grid that contains the spot is the first with an error.
  const auto coarsest = std::find_if(waves.begin(), waves.end(),
                                     [](const ordered_json& row) { return row["error"].is_number(); });
  ASSERT_LT(coarsest, std::prev(waves.end()));
  EXPECT_LT(waves.back()["error"], (*coarsest)["error"]);
  EXPECT_GT(least_error(rays), least_error(waves));
}

TEST_F(ChartRun, CutsNeedATransferFunction) {
  int found = 0;
  for (const ordered_json& family : chart_["families"])
    if (family["name"] == "bands") {
      ++found;
      ASSERT_TRUE(family["skipped"].is_string());
      EXPECT_NE(family["skipped"].get<std::string>().find("not from wave optics"), std::string::npos);
      EXPECT_EQ(family["rows"], 0);
    }
  EXPECT_EQ(found, 1);
  EXPECT_TRUE(rows("bands").empty());
}

TEST_F(ChartRun, BadUsageIsRefused) {
  for (const char* arguments :
       {"chart", "chart absent.json", "chart study.json --seconds 0", "chart study.json --seconds soon"})
    EXPECT_EQ(run_program(*folder_, arguments), 2)
        << arguments << ": " << read_file(folder_->file("stderr.txt"));
}

// The number behind `word` in a note.
double after(const std::string& word, const std::string& note) {
  const std::size_t at = note.find(word + " ");
  return at == std::string::npos ? std::nan("") : std::stod(note.substr(at + word.size()));
}

// The margin is wide, so that fits take a second.
const char* const kWaves = R"({
  "aberfit": 1,
  "mirror": { "focal_length": "1.2 m" },
  "aperture": { "shape": "circle", "diameter": "0.2 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "k-correlation", "rms": "25 nm", "B": "60 mm", "exponent": 3, "f_min": "6 /m", "f_max": "120 /m" } },
  "target": { "statistics": { "ee50": {}, "ee80": {} } },
  "equivalence": { "margin": "4 %" }
})";

TEST(ChartBands, MirrorsDifferLessTheHigherTheCutAndTheAutomaticOneIsToday) {
  ScratchFolder folder;
  folder.write("study.json", kWaves);
  ASSERT_EQ(run_program(folder, "chart study.json" + in_seconds(8) + "-o chart --pictures none"), 0)
      << read_file(folder.file("stderr.txt"));
  const ordered_json chart = ordered_json::parse(read_file(folder.file("chart/result.json")));
  std::map<double, double> spread;  // by f_c
  int defaults = 0;
  for (const ordered_json& row : chart["rows"]) {
    if (row["family"] != "bands") continue;
    SCOPED_TRACE(row.dump());
    EXPECT_GT(row["seconds"].get<double>(), 0);
    const std::string note = row["note"];
    const double differ = after("spread", note), light = after("difference", note);
    // Notes print three digits.
    EXPECT_NEAR(100 * row["error"].get<double>(), std::max(light, differ), 0.005 * std::max(light, differ));
    EXPECT_EQ(row["reference"] == "targets by wave optics", light >= differ);
    if (row["method"] == "terms alone") {
      EXPECT_EQ(differ, 0);
      continue;
    }
    EXPECT_EQ(row["method"], "terms and scatter");
    EXPECT_GT(row["terms"], 0);
    spread[row["value"]] = differ;
    if (!row["is_default"].get<bool>()) continue;
    ++defaults;
    EXPECT_NEAR(differ, 4.0 / 3, 0.005);  // a third of the margin
  }
  EXPECT_EQ(defaults, 1);
  ASSERT_GE(spread.size(), 2u);
  for (auto at = std::next(spread.begin()); at != spread.end(); ++at)
    EXPECT_LT(at->second, std::prev(at)->second) << at->first << " /m";
}

TEST(ChartOfLight, ComparesRaysWithoutWhatTheyDoNotHave) {
  for (const char* statistics : {R"({"strehl": {}, "mtf": {"frequencies": ["50 /mm"]}, "ee80": {}})",
                                 R"({"ensquared_within": {"sides": ["10 um"]}})"}) {
    SCOPED_TRACE(statistics);
    ScratchFolder folder;
    ordered_json study = ordered_json::parse(kWaves);
    study["target"]["statistics"] = ordered_json::parse(statistics);
    folder.write("study.json", study.dump());
    ASSERT_EQ(run_program(folder, "chart study.json" + in_seconds(4) + "-o chart --pictures none"), 0)
        << read_file(folder.file("stderr.txt"));
    const ordered_json chart = ordered_json::parse(read_file(folder.file("chart/result.json")));
    std::map<std::string, int> rows;
    for (const ordered_json& row : chart["rows"]) ++rows[row["family"]];
    const bool has_radii = study["target"]["statistics"].contains("ee80");
    EXPECT_GT(rows["theories"], 0);
    EXPECT_EQ(rows["models"] > 0, has_radii);
    EXPECT_EQ(rows["fits"] > 0, has_radii);
  }
}

}  // namespace
}  // namespace aberfit
