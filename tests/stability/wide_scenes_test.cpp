// Randomly generated mirrors with bands as wide as real ones: the time of an iteration and of a whole fit.
#include "wide_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "aberfit/chart/check.h"
#include "aberfit/commands/run.h"

namespace aberfit {
namespace {

constexpr int kThreads = 2;
constexpr double kLongest = 120;  // [s]

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double checked_cycles(const CheckReport& report, const Study& study) {
  return report.shares ? report.shares->cut * 2 * aperture_radius(study.aperture) : std::nan("");
}

struct Timed {
  double actual = 0;  // [s]
  CheckReport report;
  ResultDocument result;
};

Timed timed(const Study& study) {
  Timed timed;
  timed.report = make_check(study, {kThreads, {}, {}}, true);
  RunOptions options;
  options.threads = kThreads;
  options.pictures = PictureFormat::kNone;
  const auto begin = std::chrono::steady_clock::now();
  timed.result = run_fit(study, options);
  timed.actual = seconds_since(begin);
  return timed;
}

// Prints one line: the scene, its cut, its terms, one iteration as `check` predicts it, and the time of the
// fit.
void print(int k, const WideScene& scene, const Study& study, const Timed& timed) {
  std::printf("%2d %-72s cut %6.1f cycles %5d terms  iteration %6.2f s  fit %7.1f s  %s\n", k,
              scene.name.c_str(), checked_cycles(timed.report, study), int(timed.result.fitted.terms.size()),
              timed.report.cost->iteration_seconds.value_or(std::nan("")), timed.actual,
              to_string(timed.result.judgement.verdict).c_str());
  std::fflush(stdout);
}

class WideMatrix : public testing::TestWithParam<int> {};

// The scenes run one after the other, or singly with --gtest_filter='*/12'. The times need an idle machine
// and a release build.
TEST_P(WideMatrix, TakesLessThanTwoMinutes) {
  const WideScene scene = wide_scene(GetParam());
  const Study study = study_of(scene, testing::TempDir());
  const Timed now = timed(study);
  print(GetParam(), scene, study, now);
  EXPECT_LE(now.actual, kLongest) << scene.study;
  EXPECT_NE(now.result.judgement.verdict, Verdict::kDifferent) << scene.study;
}
INSTANTIATE_TEST_SUITE_P(Seeded, WideMatrix, testing::Range(0, kWideScenes));

// The cheapest scenes, one of them without terms. Times are not tested, because other tests run beside them.
class WideMatrixSmoke : public testing::TestWithParam<int> {};
TEST_P(WideMatrixSmoke, DoesNotFail) {
  const WideScene scene = wide_scene(GetParam());
  const Study study = study_of(scene, testing::TempDir());
  const Timed now = timed(study);
  print(GetParam(), scene, study, now);
  EXPECT_NE(now.result.judgement.verdict, Verdict::kDifferent) << scene.study;
}
INSTANTIATE_TEST_SUITE_P(Seeded, WideMatrixSmoke, testing::Values(1, 14));

// The table of a scene has the RMS height of the scene.
TEST(WideScenes, TablesHaveTheHeightOfTheirG) {
  for (const int k : {4, 9, 14}) {
    const WideScene scene = wide_scene(k);
    const Study study = study_of(scene, testing::TempDir());
    ASSERT_FALSE(scene.table.empty());
    const double rms = psd_moments(RadialPsd(*study.psd)).rms_height(),
                 g = 4 * EIGEN_PI * rms / study.wavelength;
    EXPECT_GT(g, 0.1 / 1.05) << scene.name;  // trapezoids between the points
    EXPECT_LT(g, 2 * 1.05) << scene.name;
  }
}

}  // namespace
}  // namespace aberfit
