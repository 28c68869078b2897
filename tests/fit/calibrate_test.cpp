#include "aberfit/fit/calibrate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../src/fit/focus_residuals.h"
#include "aberfit/core/linear_algebra.h"
#include "fit_scene.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

std::vector<Target> targets_of_draw(const FitScene& scene, std::uint64_t seed) {
  std::vector<Statistic> statistics;
  for (const double p : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
    statistics.push_back(EncircledEnergyRadius{p, 0});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  SurfaceField field;
  scene.surface.apply(scene.prior.colour(draw_white(scene.prior.size(), seed)), &field);
  const RayBundle nominal = trace_nominal(scene.mirror, scene.pupil),
                  rays = trace(scene.mirror, scene.pupil, field);
  const Eigen::VectorXd values = evaluate_exact({rays, nominal, field.height}, statistics, 1);
  std::vector<Target> targets;
  for (std::size_t k = 0; k < statistics.size(); ++k)
    targets.push_back({statistics[k], values[Eigen::Index(k)], 0, 1e-3 * values[Eigen::Index(k)]});
  return targets;
}

}  // namespace

TEST(Calibrate, MeetsTargetsOfAnotherDrawAndStaysNearItsStart) {
  const FitScene scene(12, {}, 8192, PupilLayout::kPolar);
  const FitProblem problem = scene.problem(targets_of_draw(scene, 5));
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 6);
  FitOptions options;
  int calls = 0;
  options.progress = [&](const FitProgress& p) {
    ++calls;
    EXPECT_GE(p.cost, 0);
    return true;
  };
  const FitResult result = calibrate(problem, start, options);
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_TRUE(within_tolerance(problem, result, options.stop_at)) << result.message;
  EXPECT_GT(calls, 2);
  EXPECT_LT(result.final_cost, result.initial_cost);
  // Nearer than an independent realisation, which is sqrt(2 P) away.
  EXPECT_LT((result.white - start).norm(), std::sqrt(2.0 * double(start.size())));
  EXPECT_GT(result.rank, 0);
  EXPECT_LE(result.rank, int(problem.targets.size()));
  EXPECT_GE(result.null_directions, int(scene.terms.size() - Eigen::Index(problem.targets.size())));
}

// The mean-square radius in the focus is that of the angles times f^2, so a factor of three cannot be met.
TEST(Calibrate, OfTargetsThatContradictEachOtherIsNotConverged) {
  const FitScene scene(4, {}, 4096, PupilLayout::kPolar);
  const double sigma = scene.focal_sigma;
  const std::vector<Target> targets{{RmsRadius{}, sigma, 0, 1e-3 * sigma},
                                    {ScatterRms{}, 3 * sigma / 2.8, 0, 3e-3 * sigma / 2.8}};
  const FitProblem problem = scene.problem(targets);
  const FitResult result = calibrate(problem, draw_white(scene.prior.size(), 3), FitOptions());
  EXPECT_EQ(result.status, FitStatus::kNotConverged) << result.message;
  EXPECT_NE(result.message.find("contradict"), std::string::npos) << result.message;
}

TEST(Calibrate, GivesTheSameBitsForAnyThreadCount) {
  const FitScene scene(8, {}, 9000, PupilLayout::kPolar);  // more than two chunks of the operator
  const FitProblem problem = scene.problem(targets_of_draw(scene, 2));
  FitOptions one, two;
  two.threads = 2;
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 3);
  const FitResult a = calibrate(problem, start, one), b = calibrate(problem, start, two),
                  c = calibrate(problem, start, two);
  EXPECT_TRUE(a.coefficients == b.coefficients);
  EXPECT_TRUE(b.coefficients == c.coefficients);
  EXPECT_TRUE(a.coefficient_std == b.coefficient_std);
  EXPECT_GT(a.iterations, 2);
}

TEST(Calibrate, CanBeCancelledAndKeepsToItsBounds) {
  const FitScene scene(8, {}, 2048, PupilLayout::kPolar);
  const double sigma = scene.focal_sigma;
  const FitProblem problem = scene.problem({{EncircledEnergyRadius{0.9, 0}, 4 * sigma, 0, 1e-3 * sigma}});
  FitOptions options;
  options.progress = [](const FitProgress&) { return false; };
  EXPECT_EQ(calibrate(problem, draw_white(scene.prior.size(), 3), options).status, FitStatus::kCancelled);
  FitOptions bounded;
  bounded.bound = 1.5;
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 3).cwiseMax(-1.4).cwiseMin(1.4);
  const FitResult result = calibrate(problem, start, bounded);
  EXPECT_LE(result.white.cwiseAbs().maxCoeff(), 1.5 + 1e-12);
  EXPECT_LT(result.final_cost, result.initial_cost);
}

TEST(Posterior, MatchesTheDenseInverse) {
  const FitScene scene(6, {4}, 2048, PupilLayout::kPolar);
  std::vector<Target> targets;
  for (const double p : {0.3, 0.5, 0.9})
    targets.push_back({EncircledEnergyRadius{p, 0}, 2 * p * scene.focal_sigma, 0, 0.01 * scene.focal_sigma});
  const FitProblem problem = scene.problem(targets);
  FitOptions options;
  options.stop_at = 0;
  options.max_iterations = 30;
  const FitResult result = calibrate(problem, draw_white(scene.prior.size(), 2), options);
  // Dense twin: J by the model at the solution, covariance F (I + J^T J)^-1 F^T.
  StatisticsModel model(problem, options.smoothing.back() * scene.focal_sigma, 1);
  Eigen::VectorXd values;
  Jacobian jacobian;
  ASSERT_TRUE(model(result.white, &values, &jacobian));
  for (Eigen::Index k = 0; k < 3; ++k) jacobian.row(k) /= targets[std::size_t(k)].tolerance;
  const Eigen::Index n = scene.prior.size();
  const Eigen::MatrixXd white =
      solve_symmetric(Eigen::MatrixXd::Identity(n, n) + jacobian.transpose() * jacobian,
                      Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)));
  Eigen::MatrixXd factor(n, n);
  for (Eigen::Index j = 0; j < n; ++j) factor.col(j) = scene.prior.colour(Eigen::VectorXd::Unit(n, j));
  const Eigen::VectorXd dense = (factor * white * factor.transpose()).diagonal().cwiseSqrt();
  for (Eigen::Index j = 0; j < n; ++j) EXPECT_NEAR(result.coefficient_std[j] / dense[j], 1.0, 1e-6) << j;
  const Eigen::MatrixXd predicted = jacobian * white * jacobian.transpose();
  for (Eigen::Index k = 0; k < 3; ++k)
    EXPECT_NEAR(result.statistic_std[k] / (targets[std::size_t(k)].tolerance * std::sqrt(predicted(k, k))),
                1.0, 1e-6);
}
