#include "aberfit/report/chart.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aberfit/report/documents.h"
#include "chart/hand_made_rows.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using test::family;
using test::kNone;
using test::row;

Chart chart_of(ChartFamily f) {
  Chart chart;
  chart.title = "hand-made";
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
  const nlohmann::ordered_json json = to_json(chart, nlohmann::ordered_json::object(), Provenance{});
  EXPECT_EQ(json["rows"].size(), 2u);
  EXPECT_TRUE(json["rows"][0]["error"].is_null());
  EXPECT_EQ(json["rows"][1]["error"], 0.5);
  EXPECT_EQ(json["families"][1]["skipped"], "It does not apply.");
  const std::string table = text_of(page_of(chart));
  EXPECT_NE(table.find("It does not apply."), std::string::npos) << table;
}

TEST(ChartPlots, WriteOnePicturePerFamilyThatHasRows) {
  const test::ScratchFolder folder;
  ChartFamily f = family({row("a", 1e-3, 0.1), row("b", 1e-2, 0.01), row("b", 2e-2, 0)}, 0.05);
  f.rows[1].is_default = true;
  Warnings warnings;
  const auto drawn = draw_pictures(chart_of(f), folder.file("out"), {}, &warnings);
  std::ifstream script(folder.file("out/plots/chart_hand_made.gp"));
  EXPECT_TRUE(script.good());
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/plots/chart_left_out.gp")));
  // The chart is drawn, or a warning gives the reason.
  EXPECT_EQ(drawn.size() + warnings.size(), 1u);
  for (const Warning& warning : warnings)
    EXPECT_NE(warning.message.find("not on PATH"), std::string::npos) << warning.message;
}

}  // namespace
}  // namespace aberfit
