// When a fit of a search is given up.
#include "../../src/method/stall_watch.h"

#include <gtest/gtest.h>

#include <functional>

namespace aberfit {
namespace {

using internal::StallWatch;

// The iteration at which a fit with these mismatches is given up; 0 if not within 100.
int given_up(StallWatch watch, const std::function<double(int)>& mismatch) {
  for (int k = 1; k <= 100; ++k) {
    FitProgress progress;
    progress.iteration = k;
    progress.worst_mismatch = mismatch(k);
    if (watch.stalled(progress)) return k;
  }
  return 0;
}

// Rays: an iteration is cheap, and twelve without a tenth of progress are too many.
TEST(StallWatch, OfRaysWaitsTwelveIterationsForATenth) {
  const StallWatch watch(FocusModel::kRays, 100, false);
  EXPECT_EQ(given_up(watch, [](int) { return 30.0; }), 1 + 12);
  // Falls by a fifth in every eleventh iteration: never, until it may run to its end at 2 tolerances.
  EXPECT_EQ(given_up(watch, [](int k) { return 30 * std::pow(0.8, (k - 1) / 11); }), 0);
  // By a twentieth in each twelfth: too little.
  EXPECT_NE(given_up(watch, [](int k) { return 30 * std::pow(0.95, (k - 1) / 12); }), 0);
  // Near the tolerances a hundredth will do.
  EXPECT_EQ(given_up(watch, [](int) { return 1.9; }), 1 + 12);
  EXPECT_EQ(given_up(watch, [](int k) { return 1.9 * std::pow(0.985, (k - 1) / 11); }), 0);
  // What is met does not rest.
  EXPECT_EQ(given_up(watch, [](int k) { return k < 5 ? 1.002 : 0.999; }), 0);
}

// A finer smoothing begins further away than the coarse one ended, and is given the time to get there.
TEST(StallWatch, OfAnotherSmoothingBeginsAnew) {
  StallWatch watch(FocusModel::kRays, 100, false);
  FitProgress progress;
  const auto stalled = [&](int iteration, int solve, double mismatch) {
    progress.iteration = iteration;
    progress.solve = solve;
    progress.worst_mismatch = mismatch;
    return watch.stalled(progress);
  };
  for (int k = 1; k <= 3; ++k) EXPECT_FALSE(stalled(k, 0, 8 * std::pow(0.4, k - 1)));  // to 1.3
  for (int k = 3; k <= 40; ++k) EXPECT_FALSE(stalled(k, 1, 6 * std::pow(0.95, k - 3))) << k;
  for (int k = 41; k <= 60; ++k) EXPECT_FALSE(stalled(k, 2, 0.9));
  for (int k = 60; k < 72; ++k) EXPECT_FALSE(stalled(k, 3, 1.5)) << k;
  EXPECT_TRUE(stalled(72, 3, 1.5));
}

// Waves: the pace of five iterations has to last for the rest of the way.
TEST(StallWatch, OfWavesAsksWhetherThePaceReachesTheTolerances) {
  const StallWatch draw(FocusModel::kWaves, 100, false), warm(FocusModel::kWaves, 100, true);
  const auto falling = [](double from, double factor) {
    return [=](int k) { return std::max(from * std::pow(factor, k - 1), 1.5); };
  };
  // 5 % an iteration leave 30 x 0.95^100 = 0.2 of 30 tolerances.
  EXPECT_EQ(given_up(draw, [](int k) { return 30 * std::pow(0.95, k - 1); }), 0);
  // 1 % an iteration leave 11; told as soon as the first steps do not count.
  EXPECT_EQ(given_up(draw, falling(30, 0.99)), 11);
  EXPECT_EQ(given_up(warm, falling(30, 0.99)), 7);
  // With fewer iterations left, the same pace no longer reaches.
  EXPECT_NE(
      given_up(StallWatch(FocusModel::kWaves, 40, false), [](int k) { return 30 * std::pow(0.95, k - 1); }),
      0);
  EXPECT_EQ(given_up(draw, [](int) { return 0.9; }), 0);
  // 1.3 % an iteration leave 1.1 of 4 tolerances: enough for who may end at 2.
  const auto slow = [](int k) { return 4 * std::pow(0.987, k - 1); };
  EXPECT_NE(given_up(draw, slow), 0);
  EXPECT_EQ(given_up(StallWatch(FocusModel::kWaves, 100, false, 2), slow), 0);
}

// Terms that somebody asked for: a fit that rests for 24 iterations and falls then goes on.
TEST(StallWatch, OfWhatIsAskedForWaitsTwentyFiveIterations) {
  const StallWatch patient = StallWatch::patient(FocusModel::kRays, 100);
  EXPECT_EQ(given_up(patient, [](int) { return 800.0; }), 1 + 25);
  EXPECT_EQ(given_up(patient, [](int k) { return 800 * std::pow(0.8, (k - 1) / 24); }), 0);
  EXPECT_EQ(given_up(patient, [](int) { return 1.9; }), 1 + 25);
  EXPECT_EQ(given_up(patient, [](int k) { return 1.9 * std::pow(0.985, (k - 1) / 24); }), 0);
  // By waves, near the tolerances, as long as there are iterations.
  EXPECT_EQ(given_up(StallWatch::patient(FocusModel::kWaves, 100), [](int) { return 1.9; }), 0);
}

// By waves, besides: what will not come within ten tolerances is not worth a hundred iterations.
TEST(StallWatch, OfWhatIsAskedForByWavesMindsThePaceFarAway) {
  const StallWatch patient = StallWatch::patient(FocusModel::kWaves, 100);
  const auto falling = [](double from, double factor) {
    return [=](int k) { return from * std::pow(factor, k - 1); };
  };
  // 1 % an iteration end at 102 of 279 tolerances, 5 % at 1.6; 1 % of 20 at 7, which is of use.
  EXPECT_EQ(given_up(patient, falling(279, 0.99)), 13);
  EXPECT_EQ(given_up(patient, falling(279, 0.95)), 0);
  EXPECT_EQ(given_up(patient, falling(20, 0.99)), 0);
  EXPECT_EQ(given_up(StallWatch::patient(FocusModel::kRays, 100), falling(279, 0.99)), 0);
  EXPECT_EQ(given_up(patient, [](int) { return 9.0; }), 1 + 25);
}

}  // namespace
}  // namespace aberfit
