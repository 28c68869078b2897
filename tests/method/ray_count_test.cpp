// The number of rays or grid cells that is enough, judged by fresh ones.
#include "aberfit/method/ray_count.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "aberfit/commands/run.h"
#include "aberfit/method/constants.h"
#include "aberfit/study/read_study.h"
#include "reference_scenes.h"

namespace aberfit {
namespace {

TEST(AutomaticRays, KeepWhatAStudyNames) {
  const ResultDocument result =
      run_fit(parse_study(small_study(R"({"zernike": {"n_max": 14}})", "5000"), "study.json"), {});
  EXPECT_NEAR(double(result.fitted.rays), 5000, 250);  // polar pupils only come near the number
  ASSERT_TRUE(result.choices.rays.has_value());
  EXPECT_FALSE(result.choices.rays->automatic);
}

// The number grows while fresh rays disagree, err too much, or leave the verdict undecided, up to a maximum.
TEST(AutomaticRays, DoubleUntilFreshRaysSettleIt) {
  const auto enough = [](double gap, double error, Verdict verdict, std::int64_t rays = 16384) {
    RayChoice choice;
    choice.allowed = law::kRayShareOfMargin * 0.01;
    choice.gap = gap;
    choice.sampling_error = error;
    return explain_rays(rays, verdict, &choice);
  };
  EXPECT_TRUE(enough(0.0049, 0.0049, Verdict::kEquivalent));
  EXPECT_FALSE(enough(0.0051, 0.001, Verdict::kEquivalent));
  EXPECT_FALSE(enough(0.001, 0.0051, Verdict::kDifferent));
  EXPECT_FALSE(enough(0.001, 0.001, Verdict::kUndecided));
  EXPECT_TRUE(enough(0.02, 0.02, Verdict::kUndecided, std::int64_t(1) << 40));
  EXPECT_TRUE(enough(HUGE_VAL, HUGE_VAL, Verdict::kDifferent));  // no value, which more rays do not change
  EXPECT_EQ(more_rays(16384), 32768);
}

TEST(AutomaticRays, StayUntilFreshRaysSayTheSame) {
  const ResultDocument result =
      run_fit(parse_study(small_study(R"({"zernike": {"n_max": 14}})", "\"auto\""), "study.json"), {});
  ASSERT_TRUE(result.choices.rays.has_value());
  const RayChoice& choice = *result.choices.rays;
  EXPECT_TRUE(choice.automatic);
  EXPECT_LE(choice.gap, choice.allowed);
  EXPECT_LE(choice.sampling_error, choice.allowed);
  EXPECT_DOUBLE_EQ(choice.allowed, law::kRayShareOfMargin * 0.02);
  // The gap is computed again from the shown values.
  double gap = 0;
  for (Eigen::Index k = 0; k < result.fitted.values.size(); ++k) {
    const Target& target = result.fitted.targets[std::size_t(k)];
    gap = std::max(gap, std::abs(result.fitted.values[k] - result.fitted.validated[k]) / target.value);
  }
  // The choice computes it from energy fractions over the theory's slope. The slope of a single surface of 42
  // modes differs by a tenth or two.
  EXPECT_NEAR(choice.gap, gap, 0.25 * gap);
}

TEST(AutomaticCells, AreEnoughWhereTheJudgingGridSaysTheSame) {
  RayChoice choice;
  choice.allowed = 0.001;
  const auto enough = [&](double gap, Eigen::Index cells) {
    choice.gap = gap;
    return explain_cells(cells, 0.1, &choice);
  };
  EXPECT_TRUE(enough(0.0009, 3000));
  EXPECT_NE(choice.reason.find("3000 grid points"), std::string::npos) << choice.reason;
  EXPECT_NE(choice.reason.find("up to 0.09 %, below the allowed 0.1 % (10 % of the margin)"),
            std::string::npos)
      << choice.reason;
  EXPECT_FALSE(enough(0.0011, 3000));
  EXPECT_NE(choice.reason.find("above the allowed 0.1 %"), std::string::npos) << choice.reason;
  EXPECT_EQ(choice.reason.find("tolerances"), std::string::npos) << choice.reason;
  EXPECT_FALSE(enough(HUGE_VAL, 3000));
  EXPECT_EQ(choice.reason, kNoValueToCompare);
}

}  // namespace
}  // namespace aberfit
