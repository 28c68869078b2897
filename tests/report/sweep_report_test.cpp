// Tables and pictures of a sweep, compared with sorts and sums written anew.
#include "aberfit/report/sweep_report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/report/documents.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using test::read_file;
using test::ScratchFolder;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A sweep of rms and B with seeds; ee80 = rms B (1 + 0.01 seed), and one case failed.
SweepReport sample(std::size_t seeds) {
  SweepReport report;
  report.title = "A mirror, \"swept\"";
  report.run = "trace";
  report.has_seeds = seeds > 1;
  report.axes = {{"/roughness/psd/rms", "nm", true, true}, {"/roughness/psd/B", "m", true, false}};
  if (seeds > 1) report.axes.push_back({"/fit/seed", "", true, false});
  report.statistics = {"ee80_radius_m", "scene_g"};
  report.shown = {"ee80_radius_m"};
  for (const double rms : {10.0, 20.0, 40.0, 80.0})
    for (const double b : {0.1, 0.2, 0.3})
      for (std::size_t seed = 1; seed <= seeds; ++seed) {
        SweepRow row;
        row.index = report.rows.size();
        row.id = "id" + std::to_string(row.index);
        row.typed = {fmt::format("{} nm", rms), fmt::format("{} m", b), std::to_string(seed)};
        row.number = {rms, b, double(seed)};
        row.typed.resize(report.axes.size()), row.number.resize(report.axes.size());
        row.failed = row.index == 3;
        if (row.failed) row.error = "no focus, \"sorry\"\nat all";
        row.values = {row.failed ? kNone : 1e-6 * rms * b * (1 + 0.01 * double(seed)), 1};
        report.rows.push_back(row);
      }
  report.planned = report.rows.size();
  return report;
}

// Type 7 of Hyndman and Fan by its definition; a sample of five has its quartiles at the second and fourth.
TEST(SweepQuantiles, AreOrderStatistics) {
  const SweepQuantiles q = quantiles_of({5, kNone, 1, 4, 2, 3});
  EXPECT_EQ(q.count, 5u);
  EXPECT_EQ(q.smallest, 1);
  EXPECT_EQ(q.q25, 2);
  EXPECT_EQ(q.q50, 3);
  EXPECT_EQ(q.q75, 4);
  EXPECT_EQ(q.largest, 5);
  EXPECT_NEAR(q.q05, 1.2, 1e-15);
  EXPECT_NEAR(q.q95, 4.8, 1e-15);
  EXPECT_EQ(q.mean, 3);
  EXPECT_NEAR(q.standard_deviation, std::sqrt(2.5), 1e-15);
  EXPECT_EQ(quantiles_of({7}).q95, 7);
  EXPECT_TRUE(std::isnan(quantiles_of({7}).standard_deviation));
  EXPECT_TRUE(std::isnan(quantiles_of({kNone}).q50));
}

TEST(SweepQuantiles, AreThoseOfThePlacesRealisations) {
  const SweepReport report = sample(5);
  const auto all = sweep_quantiles(report, 0);
  ASSERT_EQ(all.size(), 12u);
  for (std::size_t place = 0; place < 12; ++place) {
    EXPECT_EQ(all[place].row, 5 * place);
    EXPECT_EQ(all[place].count, place == 0 ? 4u : 5u);
    const SweepRow& row = report.rows[5 * place];
    if (place == 0) continue;
    EXPECT_NEAR(all[place].q50 / (1e-6 * row.number[0] * row.number[1] * 1.03), 1, 1e-14);
  }
}

// RFC 4180, read by the test's own reader.
std::vector<std::vector<std::string>> read_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (c == '"' && quoted && k + 1 < text.size() && text[k + 1] == '"')
      rows.back().back() += text[++k];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      rows.back().emplace_back();
    else if (c == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

TEST(SweepReport, HasEveryCaseInItsTable) {
  const SweepReport report = sample(1);
  const auto rows = read_csv(cases_csv(report));
  ASSERT_EQ(rows.size(), 13u);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"index", "id", "/roughness/psd/rms", "/roughness/psd/B",
                                               "status", "verdict", "ee80_radius_m", "scene_g", "warnings",
                                               "seconds", "error"}));
  for (std::size_t k = 0; k < 12; ++k) {
    const auto& cells = rows[k + 1];
    ASSERT_EQ(cells.size(), 11u);
    EXPECT_EQ(cells[2], report.rows[k].typed[0]);
    EXPECT_EQ(cells[4], k == 3 ? "failed" : "done");
    if (k == 3) {
      EXPECT_EQ(cells[6], "");
      EXPECT_EQ(cells[10], report.rows[3].error);
    } else {
      EXPECT_EQ(std::stod(cells[6]), report.rows[k].values[0]);
    }
  }
  const auto quantiles = read_csv(quantiles_csv(sample(5)));
  ASSERT_EQ(quantiles.size(), 1u + 12 * 2);
  EXPECT_EQ(quantiles[0].size(), quantiles[24].size());
  EXPECT_EQ(quantiles[1][2], "ee80_radius_m");
  EXPECT_EQ(quantiles[1][3], "4");
}

TEST(SweepReport, SaysWhatIsThereAndWhatIsNot) {
  SweepReport report = sample(1);
  report.planned = 20;
  const nlohmann::ordered_json json = to_json(report, nlohmann::ordered_json::object(), {});
  EXPECT_EQ(json["cases"],
            nlohmann::ordered_json::parse(R"({"planned": 20, "recorded": 12, "done": 11, "failed": 1})"));
  EXPECT_EQ(json["failures"][0]["at"]["/roughness/psd/B"], "0.1 m");
  EXPECT_NEAR(double(json["statistics"]["ee80_radius_m"]["largest"]), 80e-6 * 0.3 * 1.01, 1e-18);
  const std::string summary = text_of(page_of(report));
  EXPECT_EQ(summary.find("NOT COMPLETE: 12 of 20 cases, 1 failed"), 0u) << summary;
  EXPECT_NE(summary.find("no focus"), std::string::npos);
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

std::vector<std::string> files_of(const SweepReport& report, const ScratchFolder& folder) {
  Warnings warnings;
  draw_pictures(report, folder.file("."), {}, &warnings);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.file("plots")))
    if (entry.path().extension() == ".gp" && entry.path().stem() != "common")
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(SweepPlots, OfAGridAreCurvesAMapAndContourLines) {
  const ScratchFolder folder;
  EXPECT_EQ(files_of(sample(5), folder),
            (std::vector<std::string>{"contour_ee80_radius", "curve_ee80_radius", "map_ee80_radius"}));
  // There is a line for each B, with the band of the seeds. At 40 nm and B = 0.2 m the median is 8.24 um.
  const std::string curves = read_file(folder.file("plots/curve_ee80_radius.dat"));
  std::istringstream table(curves.substr(curves.find("\n\n\n")));  // the second block
  double x = 0, median = 0, q05 = 0;
  for (std::string line; std::getline(table, line);)
    if (line[0] != '#' && (std::istringstream(line) >> x >> median >> q05) && x == 40) break;
  EXPECT_EQ(x, 40);
  EXPECT_NEAR(median, 8.24, 1e-8);
  EXPECT_NEAR(q05, 8.096, 1e-8);
  const std::string curve = read_file(folder.file("plots/curve_ee80_radius.values"));
  EXPECT_NE(curve.find("set logscale x"), std::string::npos);
  EXPECT_NE(curve.find("\"ee80_radius [µm]\""), std::string::npos) << curve;
  // Each pair has a field of the map, even if one case failed.
  std::istringstream cells(read_file(folder.file("plots/map_ee80_radius.dat")));
  int count = 0;
  for (std::string line; std::getline(cells, line);) count += line[0] != '#';
  EXPECT_EQ(count, 12);
}

TEST(SweepPlots, OfPointsAreTheCasesThemselves) {
  const ScratchFolder folder;
  SweepReport report = sample(1);
  report.is_grid = false;
  EXPECT_EQ(files_of(report, folder), (std::vector<std::string>{"curve_ee80_radius", "map_ee80_radius"}));
}

TEST(SweepPlots, OfWordsHaveThemAtTheAxis) {
  const ScratchFolder folder;
  SweepReport report = sample(1);
  for (SweepAxis& axis : report.axes) axis.is_numeric = false;
  for (SweepRow& row : report.rows) row.number = {kNone, kNone};
  EXPECT_EQ(files_of(report, folder), (std::vector<std::string>{"curve_ee80_radius"}));
  EXPECT_NE(read_file(folder.file("plots/curve_ee80_radius.values")).find(R"(\"20 nm\" 1)"),
            std::string::npos);
}

}  // namespace
}  // namespace aberfit
