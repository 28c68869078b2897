#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "fit_scene.h"

using namespace aberfit;

namespace {

// 24 statistics: seven EE fractions in three planes, ring width, RMS scatter, RMS height.
std::vector<Statistic> two_dozen(double unit) {
  std::vector<Statistic> statistics;
  for (const double dz : {0.0, -1.5 * unit, 1.5 * unit})
    for (const double p : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
      statistics.push_back(EncircledEnergyRadius{p, dz});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  statistics.push_back(RmsHeight{});
  return statistics;
}

constexpr double kWidth =
    0.1;  // kernel half-width of focal_sigma; truth and fit share it, so it is no error here
constexpr double kNoise = 2e-3;  // relative standard deviation of the data
constexpr double kNormal95 = 1.959963984540054;

Eigen::VectorXd smooth_values(const FitScene& scene, const std::vector<Statistic>& statistics,
                              const Eigen::VectorXd& white) {
  SurfaceField field;
  scene.surface.apply(scene.prior.colour(white), &field);
  const RayBundle nominal = trace_nominal(scene.mirror, scene.pupil),
                  rays = trace(scene.mirror, scene.pupil, field);
  Eigen::VectorXd values;
  const bool exists = evaluate_smooth({rays, nominal, field.height}, statistics, kWidth * scene.focal_sigma,
                                      1, &values, nullptr);
  return exists ? values : Eigen::VectorXd();
}

}  // namespace

TEST(Calibrate, IntervalsCoverTheTruthInRecovery) {
  // Truth from the zero-mean prior, 24 noisy statistics, 1,000 trials: the 95 % intervals of the predicted
  // statistics cover the noise-free ones.
  const FitScene scene(4, {4, 6}, 2048, PupilLayout::kPolar);
  const std::vector<Statistic> statistics = two_dozen(2.8 * scene.focal_sigma / 0.2);
  constexpr std::size_t kTrials = 1000;
  std::vector<int> covered(kTrials, 0), asked(kTrials, 0);
  std::atomic<int> stuck = 0;
  parallel_for(kTrials, 2, [&](std::size_t trial) {
    const RandomStream stream(trial, "recovery");
    // A draw without a half maximum of its ring profile is no focus and no truth: draw again.
    Eigen::VectorXd exact;
    for (std::uint64_t redraw = 0; exact.size() == 0; ++redraw)
      exact = smooth_values(scene, statistics, draw_white(scene.prior.size(), stream.bits(1000 + redraw)));
    std::vector<Target> targets;
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      const double value = exact[Eigen::Index(k)], noise = kNoise * value;
      targets.push_back({statistics[k], value + noise * stream.normal(100 + k), noise, noise});
    }
    const FitProblem problem = scene.problem(targets);
    FitOptions options;
    options.prior = PriorMode::kZeroMean;
    options.smoothing = {kWidth};
    options.stop_at = 0;  // to the minimum
    options.max_iterations = 60;
    // Few unknowns have local minima (PHYSICS 8): several starts, the cheapest counts. The half chi-squared
    // of 24 data and 14 prior terms that the truth itself would have is 19 on average; a minimum beyond 60 is
    // not the truth's.
    FitResult best;
    for (std::uint64_t start = 0; start < 16 && !(best.status != FitStatus::kNotRun && best.final_cost < 30);
         ++start) {
      const FitResult result =
          calibrate(problem, draw_white(scene.prior.size(), stream.bits(1 + start)), options);
      if (result.statistic_std.size() == 0) continue;
      if (best.status == FitStatus::kNotRun || result.final_cost < best.final_cost) best = result;
    }
    if (best.status == FitStatus::kNotRun || best.final_cost > 60) ++stuck;
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      const auto at = Eigen::Index(k);
      ++asked[trial];
      if (best.statistic_std.size() > 0)
        covered[trial] +=
            std::abs(best.smooth_statistics[at] - exact[at]) <= kNormal95 * best.statistic_std[at];
    }
  });
  int hits = 0, total = 0;
  for (std::size_t t = 0; t < kTrials; ++t) {
    hits += covered[t];
    total += asked[t];
  }
  const double coverage = double(hits) / total;
  std::printf("coverage %.4f of %d intervals, %d of %zu trials in a local minimum\n", coverage, total,
              stuck.load(), kTrials);
  EXPECT_GE(coverage, 0.93);
  EXPECT_LE(coverage, 0.97);
}
