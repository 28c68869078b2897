#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "aberfit/report/documents.h"
#include "aberfit/report/result.h"
#include "sample_result.h"

using namespace aberfit;

namespace {

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(line);
  return all;
}

std::string line_with(const std::string& text, const std::string& word) {
  for (const std::string& line : lines(text))
    if (line.find(word) != std::string::npos) return line;
  return "";
}

}  // namespace

TEST(SummaryTable, PutsTheVerdictFirst) {
  ResultDocument result = sample_result();
  EXPECT_TRUE(page_of(result, false)
                  .headline.starts_with("DIFFERENT by geometric rays: 1 of 8 statistics differs from the "
                                        "target by more than 1 %, 1 is undecided"));
  result.judgement.metrics.erase(result.judgement.metrics.begin() + 3);
  result.judgement.verdict = overall(result.judgement.metrics);
  EXPECT_TRUE(page_of(result, false)
                  .headline.starts_with("UNDECIDED by geometric rays: 0 of 7 statistics differ from the "
                                        "target by more than 1 %, 1 is undecided"));
  result.judgement.metrics.pop_back();
  result.judgement.verdict = overall(result.judgement.metrics);
  EXPECT_TRUE(text_of(page_of(result, false)).starts_with(page_of(result, false).headline.substr(0, 60)));
  EXPECT_EQ(page_of(result, false).headline,
            "EQUIVALENT by geometric rays: all 6 statistics are within 1 % of the target at 95 % confidence "
            "(1 of them was not fitted)");
  result.judgement.metrics.clear();
  EXPECT_TRUE(text_of(page_of(result, false)).starts_with("NOT JUDGED"));
}

TEST(SummaryTable, SaysHowWellRaysOrCellsKnowTheSurfaceWhereTheProgramChoseThem) {
  ResultDocument result = sample_result();
  result.choices.rays = RayChoice{true, 1e-4, 1e-4, 1e-3, "8192 rays: so and so"};
  EXPECT_EQ(line_with(text_of(page_of(result, false)), "so and so"), "Rays      8192 rays: so and so");
  result.choices.rays->automatic = false;  // named by the study
  EXPECT_EQ(line_with(text_of(page_of(result, false)), "so and so"), "");
  result.scene.model = "waves";
  result.choices.rays->reason = "1234 grid points: so and so";
  EXPECT_EQ(line_with(text_of(page_of(result, false)), "so and so"), "Grid      1234 grid points: so and so");
  result.choices.rays->reason.clear();
  EXPECT_EQ(line_with(text_of(page_of(result, false)), "Grid"), "");
}

// Headline, table and JSON of one result agree, whether rays or waves decide.
TEST(SummaryTable, SaysWhatLightSaysBesideAVerdictInRays) {
  ResultDocument result = sample_result();
  result.judgement.metrics = {tost("ee50_radius_m", false, 40e-6, 0, 40.1e-6, 0, 0.01, 0.95)};
  result.judgement.verdict = overall(result.judgement.metrics);
  LightJudgement light{false, "ghs", "", false, Verdict::kDifferent, {}};
  light.metrics = {tost("ee35_radius_m", false, 30e-6, 0, 28.8e-6, 0, 0.01, 0.95),
                   tost("ee50_radius_m", false, 40e-6, 0, 40.1e-6, 0, 0.01, 0.95)};
  result.judgement.light = light;
  const std::string beside = text_of(page_of(result, false));
  EXPECT_EQ(page_of(result, false).tone == Page::Tone::kGood, false) << "light says otherwise";
  EXPECT_EQ(page_of(result, false).headline,
            "EQUIVALENT by geometric rays: the only statistic is within 1 % of the target at 95 % confidence "
            "(all were fitted); by wave optics DIFFERENT (ee35_radius -4 %)");
  EXPECT_NE(line_with(beside, "The same surface by wave optics").size(), 0u);
  EXPECT_EQ(line_with(beside, "(this decides)"), "");
  // Here waves decide.
  result.judgement.light->decides = result.judgement.light_decides = true;
  result.judgement.verdict = Verdict::kDifferent;
  const std::string decides = text_of(page_of(result, false));
  EXPECT_TRUE(decides.starts_with("DIFFERENT by wave optics: 1 of 2 statistics differs")) << decides;
  EXPECT_NE(decides.find("Worst: ee35_radius -4 %."), std::string::npos);
  EXPECT_NE(line_with(decides, "(this decides)"), "");
  const auto json = to_json(result, {})["equivalence"];
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_EQ(json["light"]["decides"], true);
  EXPECT_EQ(json["light"]["verdict"], "different");
  EXPECT_EQ(json["light"]["metrics"][0]["name"], "ee35_radius_m");
}

TEST(SummaryTable, SaysWhatWouldHelpWhereItIsNotEquivalent) {
  ResultDocument result = sample_result();
  result.judgement.metrics = {tost("ee50_radius_m", false, 40e-6, 0, 40.3e-6, 0.2e-6, 0.01, 0.95)};
  result.judgement.verdict = overall(result.judgement.metrics);
  EXPECT_NE(text_of(page_of(result, false)).find("more rays"), std::string::npos);  // undecided
  result.judgement.metrics = {tost("ee50_radius_m", false, 40e-6, 0, 41e-6, 0, 0.01, 0.95)};
  result.judgement.verdict = overall(result.judgement.metrics);
  result.fitted.surface.captured_fraction = 0.8;
  EXPECT_NE(text_of(page_of(result, false)).find("Leave `terms` out"), std::string::npos);
  result.fitted.surface.captured_fraction = 0.999;
  result.fitted.fit.status = FitStatus::kNotConverged;
  EXPECT_EQ(text_of(page_of(result, false)).find("fit.max_iterations"), std::string::npos);  // came to rest
  result.fitted.fit.out_of_iterations = true;
  EXPECT_NE(text_of(page_of(result, false)).find("fit.max_iterations"), std::string::npos);
  EXPECT_NE(text_of(page_of(result, false)).find("or more terms"), std::string::npos);
  // The law determines the terms; with fewer modes than statistics no set can be equivalent.
  result.choices.frontier = Frontier{};
  result.has_roughness = true;
  result.scene.numbers.n_eff = 1000;
  EXPECT_EQ(text_of(page_of(result, false)).find("more terms"), std::string::npos);
  result.scene.numbers.n_eff = 0.5 * double(result.fitted.targets.size());
  EXPECT_NE(text_of(page_of(result, false)).find("modes carry the roughness (N_eff), but they have to meet"),
            std::string::npos);
  EXPECT_EQ(text_of(page_of(result, false)).find("fit.max_iterations"), std::string::npos);
}

// Rays decide if no grid resolves the phase. A remedy is given if they leave a statistic undecided.
TEST(SummaryTable, SaysWhatWouldHelpWhereLightHasNoAnswer) {
  ResultDocument result = sample_result();
  result.judgement.light = LightJudgement{true, "ghs", "the pupil would need 13030 cells", true, {}, {}};
  result.judgement.light_decides = true;
  result.judgement.metrics = {tost("ee50_radius_m", false, 40e-6, 0, 40.3e-6, 0.2e-6, 0.01, 0.95)};
  result.judgement.verdict = overall(result.judgement.metrics);
  EXPECT_EQ(result.judgement.verdict, Verdict::kUndecided);
  EXPECT_NE(text_of(page_of(result, false)).find("equivalence.margin"), std::string::npos);
  // No judged statistic is undecided, so only the obstacle is reported.
  result.judgement.metrics = {tost("ee50_radius_m", false, 40e-6, 0, 40e-6, 0, 0.01, 0.95)};
  const std::string nothing = text_of(page_of(result, false));
  EXPECT_NE(nothing.find("13030 cells."), std::string::npos);
  EXPECT_EQ(nothing.find("a larger margin"), std::string::npos);
}

TEST(SummaryTable, FitsAHundredColumnsInPlainAscii) {
  for (const bool all : {false, true}) {
    const std::string text = text_of(page_of(sample_result(), all));
    EXPECT_TRUE(
        std::all_of(text.begin(), text.end(), [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); }));
    for (const std::string& line : lines(text)) EXPECT_LE(line.size(), 100u) << line;
    EXPECT_TRUE(text.ends_with("\n"));
  }
}

TEST(SummaryTable, ShowsValuesInUnitsForPeople) {
  const std::string text = text_of(page_of(sample_result(), false));
  const std::string row = line_with(text, "ee90_radius");
  EXPECT_NE(row.find("75.41 um"), std::string::npos) << row;
  EXPECT_NE(row.find("75.45 um"), std::string::npos) << row;  // fitted
  EXPECT_NE(row.find("75.56 um"), std::string::npos) << row;  // fresh rays
  EXPECT_NE(row.find("+0.200"), std::string::npos) << row;
  EXPECT_NE(row.find("equivalent"), std::string::npos) << row;
  EXPECT_NE(line_with(text, "scatter_rms").find("35.75 urad"), std::string::npos);
  EXPECT_NE(line_with(text, "rms_height").find("100.0 nm"), std::string::npos);
  EXPECT_NE(line_with(text, "Scene     RMS height").find("6.32 urad"), std::string::npos);
}

TEST(SummaryTable, ShoutsWhatDoesNotExist) {
  const std::string row = line_with(text_of(page_of(sample_result(), false)), "  ring_fwhm");
  EXPECT_NE(row.find("DIFFERENT"), std::string::npos) << row;
  EXPECT_EQ(row.find("nan"), std::string::npos) << row;
}

TEST(SummaryTable, ListsTheWorstOfWhatItLeavesOutUnlessAllIsAsked) {
  ResultDocument result = sample_result();
  for (int i = 0; i < 20; ++i)
    result.judgement.metrics.push_back(tost("ee" + std::to_string(30 + i) + "_radius_m@0.25mm", true, 1e-5,
                                            0.0, 1e-5 * (1.0 + 1e-4 * i), 1e-9, 0.01, 0.95));
  const std::string brief = text_of(page_of(result, false)), all = text_of(page_of(result, true));
  EXPECT_NE(brief.find("the worst 5 of 22"), std::string::npos);
  EXPECT_NE(brief.find("ee85_radius@-1.5mm"),
            std::string::npos);  // undecided, so worse than any equivalent one
  EXPECT_NE(brief.find("ee49_radius@0.25mm"), std::string::npos);
  EXPECT_EQ(brief.find("ee30_radius@0.25mm"), std::string::npos);
  EXPECT_LT(brief.find("ee85_radius@-1.5mm"), brief.find("ee49_radius@0.25mm"));
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    std::string name = metric.name;
    for (const std::string suffix : {"_m", "_rad"})
      if (const std::size_t at = name.find(suffix + "@"); at != std::string::npos)
        name.erase(at, suffix.size());
    EXPECT_NE(all.find(name.substr(0, name.find_last_of('_'))), std::string::npos) << name;
  }
}

TEST(SummaryTable, MarksWhatLiesOutsideTheSpreadOfDraws) {
  ResultDocument result = sample_result();
  result.judgement.character = sample_character();
  const std::string text = text_of(page_of(result, false));
  EXPECT_NE(line_with(text, "0.00 .. 0.50 R").find("inside"), std::string::npos);
  EXPECT_NE(line_with(text, "0.50 .. 1.00 R").find("OUTSIDE"), std::string::npos);
  EXPECT_NE(line_with(text, "6 .. 12 /m").find("OUTSIDE"), std::string::npos);
  EXPECT_NE(line_with(text, "1.5 wavelengths").find("ee65"), std::string::npos);
  EXPECT_NE(line_with(text, "stop of 60 %").find("it has no grid"), std::string::npos);
  // The verdict's line names the worst statistic.
  std::string headline = page_of(result, false).headline;
  EXPECT_NE(
      headline.find(
          "; it is no realisation of this roughness: its PSD is 3.1 times the specified one at 8.49 /m"),
      std::string::npos)
      << headline;
  result.judgement.character->psd.pop_back();
  result.judgement.character->zones.pop_back();
  headline = page_of(result, false).headline;
  EXPECT_NE(headline.find("; the PSD and shape are those of a random realisation"), std::string::npos)
      << headline;
}

TEST(SummaryTable, EndsWithTheWarningsAndTheirCodes) {
  const std::string text = text_of(page_of(sample_result(), false));
  const std::size_t warning = text.find("WARNING   [realisation-spread] Draws of this");
  ASSERT_NE(warning, std::string::npos);
  EXPECT_GT(warning, text.find("Held out (judged, not fitted)"));
  const std::vector<std::string> tail = lines(text.substr(warning));
  ASSERT_GE(tail.size(), 2u);
  EXPECT_TRUE(tail[1].starts_with(std::string(10, ' '))) << tail[1];
}
