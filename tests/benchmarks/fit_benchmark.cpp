// Whole fits, from one realisation to the statistics of another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "benchmark_case.h"
#include "benchmark_scene.h"

namespace aberfit::benchmarks {
namespace {

constexpr double kMismatchAllowed = 1e-3;  // relative, exact statistics of the fitted surface
constexpr double kTolerance = 1e-3;        // of a target; fits stop at half of it on the smooth twins

struct Outcome {
  double seconds, mismatch;
  int evaluations;
  bool converged;
};

struct Work {
  Scene scene;
  std::vector<Statistic> statistics;
  FitOptions options;

  Outcome run(std::uint64_t seed) const {
    const FitProblem problem = scene.problem(targets_of(scene, statistics, 1000 + seed, kTolerance));
    const Eigen::VectorXd start = draw_white(scene.prior.size(), seed);
    FitResult result;
    const double seconds = seconds_of([&] { result = calibrate(problem, start, options); });
    SurfaceField field;
    scene.surface.apply(result.coefficients, &field);
    const Eigen::VectorXd values = scene.exact(field, statistics);
    double mismatch = 0;
    for (std::size_t k = 0; k < statistics.size(); ++k)
      mismatch = std::max(mismatch, std::abs(values[Eigen::Index(k)] / problem.targets[k].value - 1));
    return {seconds, mismatch, result.evaluations, result.status == FitStatus::kConverged};
  }
};

// Adds a row with time and error, as medians over the seeds.
void add_fit(const std::string& name, int n_max, std::int64_t rays, std::vector<Statistic> statistics,
             std::vector<double> smoothing, int seeds) {
  add_case(name, [=]() -> Timed {
    const auto work =
        std::make_shared<Work>(Work{Scene(n_max, circle_pupil(PupilLayout::kRandom, rays)), statistics, {}});
    work->options.smoothing = smoothing;
    return [=](benchmark::State& state) {
      std::vector<double> mismatch, evaluations;
      int converged = 0;
      for (auto _ : state) {
        std::vector<double> seconds;
        mismatch.clear(), evaluations.clear(), converged = 0;
        for (int seed = 1; seed <= seeds; ++seed) {
          const Outcome outcome = work->run(std::uint64_t(seed));
          seconds.push_back(outcome.seconds);
          mismatch.push_back(outcome.mismatch);
          evaluations.push_back(outcome.evaluations);
          converged += outcome.converged;
        }
        state.SetIterationTime(median(seconds));
      }
      report_error(state, converged == seeds ? median(mismatch) : std::nan(""), kMismatchAllowed);
      state.counters["worst"] = *std::max_element(mismatch.begin(), mismatch.end());
      state.counters["evaluations"] = median(evaluations);
      report_rate(state, "fits", 1);
    };
  });
}

}  // namespace

void register_cases(bool smoke) {
  const int seeds = smoke ? 3 : 11;
  const std::vector<Statistic> five = {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 0},
                                       EncircledEnergyRadius{0.9, 0}, RmsRadius{0}, RingFwhm{}};
  add_fit("Fit/5 statistics, 231 Zernikes, 15,000 random rays", 20, 15000, five, FitOptions{}.smoothing,
          seeds);
  // The spot of so many terms is lumpy, so a kernel of 0.02 changes EE 10 % by up to 6e-3.
  add_fit("Fit/12 statistics, 1,891 Zernikes, 15,000 random rays", 60, 15000, twelve_statistics(),
          {0.1, 0.02, 0.002}, seeds);
}

}  // namespace aberfit::benchmarks
