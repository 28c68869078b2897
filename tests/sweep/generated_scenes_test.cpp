// Scenes that nobody chose: what the program says of each is checked by a wave code of the tests' own.
#include "generated_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include "aberfit/commands/run.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"
#include "independent_waves.h"

namespace aberfit {
namespace {

// Of the light: what the cells at the edge of the independent code leave.
constexpr double kOwnError = 5e-4;
constexpr int kLargestGrid = 1536;  // 0.6 GB

// Largest |E(r_p) - p| over its tolerance, of all encircled energies that were judged.
double worst_by_independent_waves(const Study& study, const ResultDocument& result) {
  const Groundwork ground = lay_groundwork(study);
  const TargetSets sets = make_targets(study, ground, 2);
  std::map<double, std::vector<std::pair<double, Target>>> planes;
  for (const auto* targets : {&sets.fitted, &sets.held_out})
    for (const Target& target : *targets)
      if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic))
        planes[ee->dz].push_back({ee->fraction, target});
  // The field of view holds three times the largest radius.
  double largest = 0;
  for (const auto& [dz, wanted] : planes)
    for (const auto& [fraction, target] : wanted) largest = std::max(largest, target.value);
  const double airy = study.wavelength * study.mirror.focal_length / (2 * ground.radius);
  const int cells = std::clamp(int(std::ceil(3 * largest / airy / 128)) * 128, 256, kLargestGrid);
  IndependentWaves waves(study.mirror.focal_length, study.aperture, study.wavelength, result.terms,
                         result.fit.coefficients, cells);
  if (result.shares) {
    const RadialPsd& psd = *ground.psd;
    waves.scatter([&psd](double f) { return psd(f); }, std::max(result.shares->cut, psd.f_min()),
                  psd.f_max());
  }
  double worst = 0;
  for (const auto& [dz, wanted] : planes) {
    std::vector<double> radii;
    for (const auto& [fraction, target] : wanted) radii.push_back(target.value);
    const std::vector<double> shares = waves.shares(dz, radii);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const Target aim = aim_of(wanted[k].second);
      const double off = std::max(0.0, std::abs(shares[k] - wanted[k].first) - kOwnError);
      worst = std::max(worst, off / (study.equivalence.margin * aim.relative_to()));
    }
  }
  return worst;
}

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
  outcome.equivalent = result.verdict == Verdict::kEquivalent;
  double worst = 0;
  if (outcome.equivalent) {
    worst = worst_by_independent_waves(study, result);
    EXPECT_LE(worst, 1.0) << "equivalent, but not in light";
  }
  std::printf("%-11s %5d terms %6.1f s  worst in light %.2f%s\n", to_string(result.verdict).c_str(),
              int(result.terms.size()), seconds.count(), worst,
              outcome.counts ? "" : "  (margin sees nothing)");
  std::fflush(stdout);
  return outcome;
}

// One after the other, each by itself with --gtest_filter='*/12'.
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

// Two that take seconds.
TEST(GeneratedScenesSmoke, AreEquivalentAndTrueInLight) {
  for (const int k : {5, 11}) EXPECT_TRUE(run_scene(k).equivalent);
}

}  // namespace
}  // namespace aberfit
