#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "../../src/fit/focus_residuals.h"
#include "fit_scene.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

Eigen::VectorXd exact_statistics(const FitScene& scene, const std::vector<Statistic>& statistics,
                                 const Eigen::VectorXd& white) {
  SurfaceField field;
  scene.surface.apply(scene.prior.colour(white), &field);
  const RayBundle nominal = trace_nominal(scene.mirror, scene.pupil),
                  rays = trace(scene.mirror, scene.pupil, field);
  return evaluate_exact({rays, nominal, field.height}, statistics, 1);
}

std::vector<Target> targets_of_draw(const FitScene& scene, const std::vector<Statistic>& statistics,
                                    std::uint64_t seed, double tolerance) {
  const Eigen::VectorXd values = exact_statistics(scene, statistics, draw_white(scene.prior.size(), seed));
  std::vector<Target> targets;
  for (std::size_t k = 0; k < statistics.size(); ++k)
    targets.push_back({statistics[k], values[Eigen::Index(k)], 0, tolerance * values[Eigen::Index(k)]});
  return targets;
}

std::vector<Statistic> dozen() {
  std::vector<Statistic> statistics;
  for (const double p : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95})
    statistics.push_back(EncircledEnergyRadius{p, 0});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  return statistics;
}

}  // namespace

TEST(CalibrateSpeed, FiveStatisticsOfAnotherDrawTakeAFewIterations) {
  constexpr int kPairs = 20;
  constexpr double kTolerance = 1e-3;  // relative
  // The exact statistics differ from the smooth ones by the rays within the kernel: c sqrt(2 w p N) / (p N)
  // of a focal sigma. With w = 0.02, p = 0.5 (density per sigma), N = 15,000 and c^2 = 0.1 (variance left by
  // the kernel) that is 5e-4. The tolerance is three of that plus half a tolerance; largest seen 1.3e-3.
  constexpr double kExactTolerance = 2e-3;
  constexpr double kSeconds = 0.4;  // ten times the time on an idle core
  const FitScene scene(20, {}, 15000, PupilLayout::kRandom, 1.0, 2.5, 19.96);
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 0},
                                             EncircledEnergyRadius{0.9, 0}, RmsRadius{0}, RingFwhm{}};
  int iterations = 0, evaluations = 0;
  double fastest = 1e9;
  for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
    const FitProblem problem = scene.problem(targets_of_draw(scene, statistics, 1000 + 2 * pair, kTolerance));
    const auto begin = std::chrono::steady_clock::now();
    const FitResult result = calibrate(problem, draw_white(scene.prior.size(), 1001 + 2 * pair), {});
    fastest =
        std::min(fastest, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    EXPECT_EQ(result.status, FitStatus::kConverged) << pair;
    EXPECT_TRUE(within_tolerance(problem, result, 1.0)) << pair;
    EXPECT_LE(result.iterations, 12) << pair;
    iterations += result.iterations;
    evaluations += result.evaluations;
    const Eigen::VectorXd exact = exact_statistics(scene, statistics, result.white);
    for (std::size_t k = 0; k < statistics.size(); ++k)
      EXPECT_NEAR(exact[Eigen::Index(k)] / problem.targets[k].value, 1.0, kExactTolerance) << pair;
  }
  EXPECT_LE(iterations, 5 * kPairs);
  EXPECT_LE(evaluations, 6 * kPairs);
  EXPECT_LE(fastest, kSeconds);
}

TEST(CalibrateSpeed, TenThousandTermsNeedNoSquareMatrix) {
  // 1,888 Zernikes and 4,056 Fourier modes. A matrix of terms x terms would take 800 MB.
  constexpr long kMostKilobytes = 400 * 1024;
  Mirror mirror;
  mirror.focal_length = 2.8;
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kSobol, 8192, 1});
  const RadialPsd psd(UniformPsd{100e-9, 2.5, 200});
  TermSet terms;
  terms.radius = 0.2;
  terms.zernike = zernike_modes(2, 60);
  terms.fourier = fourier_modes(psd.band(61 / (2 * EIGEN_PI * terms.radius), 200), 4056, 1);
  ASSERT_EQ(terms.size(), 10000);
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  const SurfaceOperator surface(terms, pupil, OperatorOptions{2, {}, {}});
  const double focal_sigma = 2 * mirror.focal_length * EIGEN_PI * 100e-9 * 200;  // f 2 s, s = pi sigma f_max
  FitProblem problem{{mirror, pupil, surface}, prior, {}, {}, focal_sigma};
  for (const Statistic& statistic : dozen()) {
    // 5 % wider than a stationary Gaussian spot of this slope.
    double value = 1.05 * focal_sigma;
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic))
      value *= std::sqrt(-2 * std::log1p(-ee->fraction));
    if (std::holds_alternative<ScatterRms>(statistic)) value *= std::sqrt(2.0) / mirror.focal_length;
    if (std::holds_alternative<RingFwhm>(statistic))
      value *= 2.80675977 * 2.14596603 * mirror.focal_length / terms.radius;
    problem.targets.push_back({statistic, value, 0, 5e-3 * value});
  }
  FitOptions options;
  options.threads = 2;
  const FitResult result = calibrate(problem, draw_white(prior.size(), 3), options);
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_TRUE(within_tolerance(problem, result, 1.0)) << result.message;
  EXPECT_LE(result.iterations, 15);
  EXPECT_EQ(result.null_directions, 10000 - 12);
  EXPECT_TRUE(result.operator_choice.zernike.has_value());
  EXPECT_TRUE(result.operator_choice.fourier.has_value());
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, kMostKilobytes);
}

TEST(Calibrate, ReachesTheSameMinimumInFewUnknownsAsInAll) {
  // Bounds far away make the solver use all coefficients as unknowns.
  const FitScene scene(8, {}, 4000, PupilLayout::kSobol);
  FitOptions few, all;
  few.stop_at = all.stop_at = 0;
  few.smoothing = all.smoothing = {0.3};
  few.max_iterations = all.max_iterations = 300;
  all.bound = 1e3;
  // The prior keeps both near their starts; otherwise they creep along valleys for hundreds of iterations.
  for (const std::uint64_t seed : {6u, 7u, 8u}) {
    // Two targets contradict each other, so that no point meets all tolerances and the solver runs to the
    // minimum. Their equal rows of the Jacobian are one direction fewer than there are statistics.
    const EncircledEnergyRadius median{0.5, 0};
    std::vector<Target> targets =
        targets_of_draw(scene, {median, median, EncircledEnergyRadius{0.9, 0}, ScatterRms{}}, 5, 0.05);
    targets[1].value *= 1.5;
    const FitProblem problem = scene.problem(targets);
    const Eigen::VectorXd start = draw_white(scene.prior.size(), seed);
    const FitResult a = calibrate(problem, start, few), b = calibrate(problem, start, all);
    // Both stop at a relative change of the cost below 1e-9; steps that shrink by 1e-4 each would still leave
    // 1e-5. Largest seen 1.1e-6, with the lower cost in few unknowns. The distance is the square root of that
    // times the conditioning of the valley.
    EXPECT_EQ(a.status, FitStatus::kConverged) << a.message;
    EXPECT_EQ(b.status, FitStatus::kConverged) << b.message;
    EXPECT_NEAR(a.final_cost / b.final_cost, 1.0, 1e-5) << seed;
    EXPECT_LT(a.final_cost, (1 + 1e-6) * b.final_cost) << seed;
    EXPECT_LT((a.white - b.white).norm(), 1e-2 * b.white.norm());
  }
}

TEST(StatisticsModel, RemembersATraceWithoutChangingABit) {
  const FitScene scene(8, {4}, 4000, PupilLayout::kPolar);
  std::vector<Statistic> statistics = dozen();
  statistics.push_back(RmsHeight{});
  const FitProblem problem = scene.problem(targets_of_draw(scene, statistics, 5, 1e-3));
  const double width = 0.1 * scene.focal_sigma;
  const Eigen::VectorXd here = draw_white(scene.prior.size(), 2), there = draw_white(scene.prior.size(), 3);
  StatisticsModel fresh(problem, width, 1), used(problem, 3 * width, 2);
  Eigen::VectorXd values, again;
  Jacobian jacobian, jacobian_again;
  ASSERT_TRUE(fresh(here, &values, &jacobian));
  ASSERT_TRUE(used(there, &again, &jacobian_again));
  ASSERT_TRUE(used(here, &again, nullptr));
  EXPECT_FALSE(again == values);  // another width
  used.set_width(width);
  ASSERT_TRUE(used(here, &again, &jacobian_again));
  EXPECT_TRUE(again == values);
  EXPECT_TRUE(jacobian_again == jacobian);

  // The definition is one adjoint pass per statistic.
  SurfaceField field;
  scene.surface.apply(scene.prior.colour(here), &field);
  const RayBundle nominal = trace_nominal(scene.mirror, scene.pupil),
                  rays = trace(scene.mirror, scene.pupil, field);
  std::vector<StatisticGradient> gradients;
  ASSERT_TRUE(evaluate_smooth({rays, nominal, field.height}, statistics, width, 1, &again, &gradients));
  for (std::size_t k = 0; k + 1 < statistics.size(); ++k) {  // all but RmsHeight
    const RayGradient& of_rays = gradients[k].rays;
    const SurfaceField weights = trace_adjoint(scene.mirror, scene.pupil, field, of_rays);
    const Eigen::VectorXd row =
        scene.prior.colour_transpose(of_rays.all_rays ? scene.surface.apply_transpose(weights)
                                                      : scene.surface.apply_transpose(of_rays.rays, weights));
    EXPECT_LT((jacobian.row(Eigen::Index(k)).transpose() - row).norm(), 1e-12 * row.norm()) << k;
  }
}
