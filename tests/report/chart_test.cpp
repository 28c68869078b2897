#include "aberfit/report/chart.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "study/scratch_folder.h"

namespace aberfit {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

ChartRow row(const std::string& method, double seconds, double error) {
  ChartRow r;
  r.family = "hand-made";
  r.method = method;
  r.parameter = "rays";
  r.unit = "1";
  r.value = 1024 * (seconds > 0 ? seconds : 1);
  r.seconds = r.seconds_low = r.seconds_high = seconds;
  r.error = r.error_rms = error;
  r.repeats = 5;
  return r;
}

ChartFamily family(std::vector<ChartRow> rows, double tolerance) {
  ChartFamily f;
  f.name = "hand-made";
  f.title = "Made by hand";
  f.error_of = "error, made up";
  f.timed = "nothing";
  f.tolerance = tolerance;
  f.tolerance_of = "a wish";
  f.rows = std::move(rows);
  mark_rows(&f);
  return f;
}

std::string frontier(const ChartFamily& f) {
  std::string names;
  for (const ChartRow& r : f.rows)
    if (r.on_frontier) names += r.method;
  return names;
}

std::string cheapest(const ChartFamily& f) {
  std::string names;
  for (const ChartRow& r : f.rows)
    if (r.is_cheapest_within_tolerance) names += r.method;
  return names;
}

TEST(ChartFrontier, HoldsWhatNothingBeats) {
  // b is slower and worse than a; d is slower than c at the same error; e is the most accurate.
  const ChartFamily f = family(
      {row("a", 1, 0.1), row("b", 2, 0.2), row("c", 3, 0.01), row("d", 4, 0.01), row("e", 9, 0)}, 0.05);
  EXPECT_EQ(frontier(f), "ace");
  EXPECT_EQ(cheapest(f), "c");
}

TEST(ChartFrontier, KeepsBothOfATieAndNeitherOfTwoThatAThirdBeats) {
  EXPECT_EQ(frontier(family({row("a", 1, 0.1), row("b", 1, 0.1)}, 1)), "ab");
  EXPECT_EQ(cheapest(family({row("a", 1, 0.1), row("b", 1, 0.1)}, 1)), "a");
  // Equally fast, one more accurate; equally accurate, one faster.
  EXPECT_EQ(frontier(family({row("a", 1, 0.2), row("b", 1, 0.1), row("c", 2, 0.1)}, 1)), "b");
  EXPECT_EQ(cheapest(family({row("a", 1, 0.2), row("b", 1, 0.1), row("c", 2, 0.1)}, 1)), "b");
  EXPECT_EQ(frontier(family({row("a", 2, 0.2), row("b", 2, 0.2), row("c", 1, 0.1)}, 1)), "c");
}

TEST(ChartFrontier, LeavesOutWhatHasNoErrorOrNoTime) {
  const ChartFamily f = family({row("a", 1, kNone), row("b", kNone, 0), row("c", 5, 0.5)}, 0.6);
  EXPECT_EQ(frontier(f), "c");
  EXPECT_EQ(cheapest(f), "c");
  EXPECT_EQ(frontier(family({}, 1)), "");
}

TEST(ChartFrontier, ClaimsNoToleranceThatIsMissedOrThatTheReferenceCannotTell) {
  EXPECT_EQ(cheapest(family({row("a", 1, 0.2), row("b", 2, 0.1)}, 0.05)), "");
  ChartRow vague = row("a", 1, 0.01);
  vague.error_of_reference = 0.1;
  EXPECT_EQ(cheapest(family({vague, row("b", 2, 0.01)}, 0.05)), "b");
  EXPECT_EQ(frontier(family({vague, row("b", 2, 0.01)}, 0.05)), "a");
}

TEST(StepLaw, HasItsBestStepWhereTruncationAndRoundingBalance) {
  // PHYSICS 8: uniform PSD to 1000 /m, s = 6.3e-6: best step (2.6e-15 / f_max^2)^(1/3).
  const double f_max = 1000, u = 2 * 3.14159265358979 * f_max;
  const StepLaw law{0.0932 * u * u, 1.2e-19 / 6.3e-6};
  const double best = std::cbrt(2.6e-15 / (f_max * f_max));
  EXPECT_NEAR(law.best_step(), best, 0.01 * best);  // two printed digits
  for (const double away : {0.8, 1.25}) EXPECT_GT(law(away * law.best_step()), law(law.best_step()));
}

Chart chart_of(ChartFamily f) {
  Chart chart;
  chart.title = "hand-made";
  chart.study = nlohmann::ordered_json::object();
  chart.families.push_back(std::move(f));
  ChartFamily skipped;
  skipped.name = "left-out";
  skipped.title = "Left out";
  skipped.skipped = "It does not apply.";
  chart.families.push_back(skipped);
  return chart;
}

TEST(ChartFiles, HoldEveryRowAndNoNumberThatDoesNotExist) {
  ChartRow quoted = row("a, \"b\"", 1, kNone);
  quoted.note = "comma, and quote \"";
  const Chart chart = chart_of(family({quoted, row("c", 2, 0.5)}, 1));
  const std::string csv = chart_csv(chart);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_NE(csv.find("\"a, \"\"b\"\"\""), std::string::npos) << csv;
  EXPECT_EQ(csv.find("nan"), std::string::npos) << csv;
  const nlohmann::ordered_json json = to_json(chart);
  EXPECT_EQ(json["rows"].size(), 2u);
  EXPECT_TRUE(json["rows"][0]["error"].is_null());
  EXPECT_EQ(json["rows"][1]["error"], 0.5);
  EXPECT_EQ(json["families"][1]["skipped"], "It does not apply.");
  const std::string table = summary_table(chart);
  EXPECT_NE(table.find("It does not apply."), std::string::npos) << table;
}

TEST(ChartPlots, WriteOnePicturePerFamilyThatHasRows) {
  const test::ScratchFolder folder;
  ChartFamily f = family({row("a", 1e-3, 0.1), row("b", 1e-2, 0.01), row("b", 2e-2, 0)}, 0.05);
  f.rows[1].is_default = true;
  Warnings warnings;
  const auto drawn = write_chart_plots(chart_of(f), folder.file("out"), &warnings);
  std::ifstream script(folder.file("out/plots/chart_hand_made.gp"));
  EXPECT_TRUE(script.good());
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/plots/chart_left_out.gp")));
  // Either it was drawn, or a warning says why not.
  EXPECT_EQ(drawn.size() + warnings.size(), 1u);
  for (const Warning& warning : warnings)
    EXPECT_NE(warning.message.find("not on PATH"), std::string::npos) << warning.message;
}

}  // namespace
}  // namespace aberfit
