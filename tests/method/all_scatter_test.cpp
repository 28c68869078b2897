// Number of random mirrors behind a verdict where no frequency needs a term.
#include "aberfit/method/all_scatter.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/method/constants.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// A smooth 0.3 m f/24 annulus, dozens of correlation lengths across, which needs no terms.
ResultDocument fitted(double rms_nm, double correlation_mm) {
  return run_fit(
      parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "7.06 m"}}, "aperture":
    {{"shape": "annulus", "diameter": "0.3 m", "inner_diameter": "0.101 m"}}, "light": {{"wavelength": "1 um"}},
    "roughness": {{"psd": {{"model": "gaussian", "rms": "{} nm", "correlation_length": "{} mm"}}}},
    "output": {{"pictures": "none"}}}})",
                              rms_nm, correlation_mm),
                  "study.json"),
      {});
}

double widest(const ResultDocument& result) {
  double widest = 0;
  for (const EquivalenceMetric& metric : result.judgement.metrics)
    widest = std::max(widest, 0.5 * (metric.interval[1] - metric.interval[0]) / metric.margin);
  return widest;
}

TEST(AllScatter, DrawsMoreMirrorsWhereTheySpreadTooFarToTell) {
  const ResultDocument steady = fitted(6, 0.5), wide = fitted(19.45, 1.0195);
  for (const ResultDocument* result : {&steady, &wide}) {
    ASSERT_EQ(result->fitted.terms.size(), 0);
    EXPECT_EQ(result->judgement.verdict, Verdict::kEquivalent);
  }
  EXPECT_EQ(steady.judgement.metrics.front().degrees_of_freedom, law::kGroups - 1);
  EXPECT_LE(widest(steady), law::kShareOfMargin);
  const double draws = wide.judgement.metrics.front().degrees_of_freedom + 1;
  EXPECT_GT(draws, law::kGroups);
  EXPECT_LE(draws, law::kMostDraws);
  EXPECT_TRUE(draws == law::kMostDraws || widest(wide) < 0.4);
}

// Few low frequencies carry the height, so the largest number of mirrors with images does not determine it to
// the margin. Surfaces without images are cheap, and more of them decide.
TEST(AllScatter, DrawsSurfacesAloneUntilTheirHeightIsKnown) {
  const ResultDocument result = run_fit(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "85 mm"}, "aperture": {"shape": "rectangle",
        "width": "16 mm", "height": "3.3 mm"}, "light": {"wavelength": "641 nm"}, "roughness": {"psd": {"model":
        "k-correlation", "rms": "1.13 nm", "B": "2.36 mm", "exponent": 2.63, "f_min": "31 /m", "f_max": "2.9 /mm"}},
        "equivalence": {"margin": "1.5 %"}, "output": {"pictures": "none"}})",
                  "study.json"),
      {});
  ASSERT_EQ(result.fitted.terms.size(), 0);
  const auto height =
      std::find_if(result.judgement.metrics.begin(), result.judgement.metrics.end(),
                   [](const EquivalenceMetric& metric) { return metric.name == "rms_height_m"; });
  ASSERT_NE(height, result.judgement.metrics.end());
  EXPECT_LT(0.5 * (height->interval[1] - height->interval[0]) / height->margin, 0.4);
  // kMostDraws mirrors would give a wider interval of the height.
  EXPECT_LE(result.judgement.metrics.front().degrees_of_freedom, law::kMostDraws - 1);
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
}

// The number of mirrors with images is limited, and only statistics of the surface use further surfaces.
TEST(AllScatter, DrawsNoSurfacesWhereLightAloneIsJudged) {
  std::string said;
  RunOptions options;
  options.progress = [&said](const std::string& line) { said += line + "\n"; };
  const ResultDocument result = run_fit(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "85 mm"}, "aperture": {"shape": "circle",
        "diameter": "8 mm"}, "light": {"wavelength": "641 nm"}, "roughness": {"psd": {"model": "k-correlation",
        "rms": "25 nm", "B": "2.4 mm", "exponent": 2.6, "f_min": "31 /m", "f_max": "2.9 /mm"}}, "terms":
        {"band": "10 /m"}, "target": {"statistics": {"ee50": {}, "ee90": {}}}, "output": {"pictures": "none"}})",
                  "study.json"),
      options);
  ASSERT_EQ(result.fitted.terms.size(), 0);
  EXPECT_EQ(result.judgement.metrics.front().degrees_of_freedom, law::kMostDraws - 1);
  EXPECT_EQ(said.find("heights and slopes"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
