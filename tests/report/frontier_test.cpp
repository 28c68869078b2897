#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/report/documents.h"
#include "plot_scene.h"

using namespace aberfit;

namespace {

// A search over `count` orders from n = 2 that takes the last but one.
Frontier sample_frontier(int count) {
  Frontier frontier;
  frontier.margin = 0.01;
  frontier.seconds = 2.5;
  frontier.message = "a sentence";
  for (int i = 0; i < count; ++i) {
    FrontierPoint point;
    point.order = i + 2;
    point.terms = (i + 3) * (i + 4) / 2 - 3;
    point.rays = 4096;
    point.fitted_mismatch = std::pow(10.0, 3 - 3.5 * i / (count - 2));
    point.seconds = 0.1 + 0.05 * i;
    if (i >= count - 3) {  // the others were not judged
      point.held_out_mismatch = 0.012 - 0.002 * (i - count + 3);
      point.passes = i >= count - 2;
      point.verdict = point.passes ? Verdict::kEquivalent : Verdict::kDifferent;
      point.chosen = i == count - 2;
    }
    frontier.points.push_back(point);
  }
  return frontier;
}

TEST(Frontier, IsInTheResultWithEveryNumberOfASet) {
  ResultDocument result = sample_result();
  EXPECT_FALSE(to_json(result, sample_study())["fit"].contains("frontier"));
  result.choices.frontier = sample_frontier(9);
  const auto json = to_json(result, sample_study())["fit"]["frontier"];
  ASSERT_EQ(json["points"].size(), 9u);
  const auto& first = json["points"][0];
  EXPECT_EQ(first["order"], 2);
  EXPECT_EQ(first["terms"], 3);
  EXPECT_TRUE(first["held_out_mismatch"].is_null());
  EXPECT_TRUE(first["verdict"].is_null());
  const auto& taken = json["points"][7];
  EXPECT_EQ(taken["order"], 9);
  EXPECT_EQ(taken["verdict"], "equivalent");
  EXPECT_EQ(taken["chosen"], true);
  EXPECT_EQ(taken["held_out_mismatch"], 0.010);
  EXPECT_EQ(json["margin"], 0.01);
}

TEST(Frontier, SummaryShowsEverySetWhereThereIsMoreThanOne) {
  ResultDocument result = sample_result();
  const auto rows = [&](int count) {
    result.choices.frontier = sample_frontier(count);
    if (count == 1) result.choices.frontier->points.front().chosen = true;
    std::istringstream lines(text_of(page_of(result, false)));
    int found = 0;
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 100u) << line;
      found += line.starts_with("  n <= ");
    }
    return found;
  };
  EXPECT_EQ(rows(5), 5);
  const std::string text = text_of(page_of(result, false));
  EXPECT_NE(text.find("a sentence; 2.5 s"), std::string::npos) << text;
  EXPECT_NE(text.find("equivalent, taken"), std::string::npos) << text;
  EXPECT_EQ(rows(1), 0);
}

TEST(Frontier, PictureHasEverySetInItsData) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "aberfit_frontier_picture";
  std::filesystem::remove_all(folder);
  PlotScene scene;
  scene.result.choices.frontier = sample_frontier(12);
  Warnings warnings;
  scene.write(folder.string(), &warnings);
  const auto rows = [&](const char* name) {
    std::ifstream file(folder / "plots" / name);
    EXPECT_TRUE(file) << name;
    int count = 0;
    for (std::string line; std::getline(file, line);) count += !line.starts_with("#");
    return count;
  };
  EXPECT_EQ(rows("frontier_failed.dat"), 10);
  EXPECT_EQ(rows("frontier_passed.dat"), 2);
  EXPECT_EQ(rows("frontier_chosen.dat"), 1);
  EXPECT_EQ(rows("frontier_all.dat"), 12);
  EXPECT_TRUE(std::filesystem::exists(folder / "plots" / "frontier.gp"));
  if (warnings.empty()) {  // gnuplot is there
    EXPECT_GT(std::filesystem::file_size(folder / "plots" / "frontier.svg"), 10000u);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
