// Randomly generated scenes. A wave code of the tests' own checks the verdict on each.
#include "generated_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"
#include "independent_verdict.h"

namespace aberfit {
namespace {

struct Outcome {
  bool counts = true, equivalent = false;
};

Outcome run_scene(int k) {
  const GeneratedScene scene = generated_scene(k);
  SCOPED_TRACE(scene.name);
  std::printf("%2d %-60s ", k, scene.name.c_str());
  std::fflush(stdout);
  const auto begin = std::chrono::steady_clock::now();
  const Study study = parse_study(scene.study, "scene.json");
  Outcome outcome;
  ResultDocument result;
  try {
    result = run_fit(study, {});
  } catch (const std::exception& error) {
    ADD_FAILURE() << "refused: " << error.what();
    return outcome;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  outcome.counts = std::none_of(result.warnings.begin(), result.warnings.end(),
                                [](const Warning& w) { return w.code == "margin-sees-nothing"; });
  outcome.equivalent = result.judgement.verdict == Verdict::kEquivalent;
  double worst = 0;
  if (outcome.equivalent) {
    std::optional<double> cut;
    if (result.band.shares) cut = result.band.shares->cut;
    const SecondOpinions opinions(study);
    const OpinionLimits limits{.seconds = 7200, .narrow_field = true};
    SecondOpinion light = opinions.of_waves(result.fitted.terms, result.fitted.fit.coefficients, cut, limits);
    // A spot of hundreds of Airy radii is too wide for any grid, but rays describe it.
    if (std::isnan(light.worst))
      light = opinions.of_rays(result.fitted.terms, result.fitted.fit.coefficients, limits);
    worst = light.worst;
    EXPECT_TRUE(worst <= 1.0) << "equivalent, but not by wave optics: " << light.statistic << light.obstacle;
  }
  std::printf("%-11s %5d terms %6.1f s  worst by waves %.2f%s\n", to_string(result.judgement.verdict).c_str(),
              int(result.fitted.terms.size()), seconds.count(), worst,
              outcome.counts ? "" : "  (margin sees nothing)");
  std::fflush(stdout);
  return outcome;
}

// The scenes run one after the other, or singly with --gtest_filter='*/12'.
class GeneratedScenes : public testing::TestWithParam<int> {
 protected:
  static constexpr int kScenes = 30, kMayFail = 3;
  static void TearDownTestSuite() {
    if (run == kScenes) {
      EXPECT_GE(equivalent, counted - kMayFail) << "equivalent, of " << counted;
    }
  }
  static int run, counted, equivalent;
};
int GeneratedScenes::run = 0, GeneratedScenes::counted = 0, GeneratedScenes::equivalent = 0;

TEST_P(GeneratedScenes, AreTrueInLightWhereTheyAreEquivalent) {
  const Outcome outcome = run_scene(GetParam());
  ++run;
  counted += outcome.counts;
  equivalent += outcome.counts && outcome.equivalent;
}
INSTANTIATE_TEST_SUITE_P(Seeded, GeneratedScenes, testing::Range(0, 30));

// A scene that takes seconds.
TEST(GeneratedScenesSmoke, AreEquivalentAndTrueInLight) { EXPECT_TRUE(run_scene(5).equivalent); }

}  // namespace
}  // namespace aberfit
