// Claims of fits/smooth-waves/README.md about waves, and about rays instead of them.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "fits/expected.h"

using namespace aberfit;

namespace {

constexpr double kMeets = 5e-3;  // of the target

const char* const kFolder = ABERFIT_SOURCE_DIR "/fits/smooth-waves";

Study smooth_waves() { return read_study(std::string(kFolder) + "/study.json"); }

}  // namespace

TEST(SmoothWaves, MeetTheHarveyShackFocusThroughDiffraction) {
  const Study study = smooth_waves();
  const ResultDocument result = run_fit(study, {});
  test::expect_what_the_file_says(to_json(result, resolved(study, result)), kFolder);
  EXPECT_EQ(result.scene.theory, "ghs");
  EXPECT_EQ(result.scene.model, "waves");
  EXPECT_LT(result.scene.numbers.kappa, 0.85);
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged) << result.fitted.fit.message;
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  std::size_t held_out = 0;
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    held_out += metric.held_out;
    if (!metric.held_out) {
      EXPECT_LE(std::abs(metric.difference), kMeets) << metric.name;
    }
    EXPECT_EQ(metric.verdict, Verdict::kEquivalent) << metric.name;
  }
  EXPECT_EQ(result.fitted.targets.size(), 66u);
  EXPECT_EQ(held_out, 90u);
}

TEST(SmoothWaves, ForcedToRaysAreDifferentAndSayWhy) {
  Study study = smooth_waves();
  study.target.theory = Theory::kGeometric;
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.scene.model, "rays");
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged)
      << result.fitted.fit.message;                           // as far as rays see
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);  // by the theory that was named
  ASSERT_TRUE(result.judgement.light.has_value());
  EXPECT_EQ(result.judgement.light->verdict, Verdict::kDifferent);
  const std::string headline = page_of(result, false).headline;
  EXPECT_EQ(headline.find("EQUIVALENT by geometric rays: all "), 0u) << headline;
  EXPECT_NE(headline.find("; by wave optics DIFFERENT ("), std::string::npos) << headline;
}
