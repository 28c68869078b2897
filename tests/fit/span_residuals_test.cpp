#include "../../src/fit/span_residuals.h"

#include <ceres/gradient_checker.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include "aberfit/core/linear_algebra.h"
#include "diffracted_scene.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

// A xi - b.
class LinearResiduals : public WhiteResiduals {
 public:
  LinearResiduals(Eigen::MatrixXd slopes, Eigen::VectorXd aims)
      : WhiteResiduals(int(slopes.rows()), slopes.cols()),
        slopes_(std::move(slopes)),
        aims_(std::move(aims)) {}
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override {
    result->values = slopes_ * white;
    result->residuals = result->values - aims_;
    if (with_jacobian) result->jacobian = slopes_;
    return true;
  }

 private:
  Eigen::MatrixXd slopes_;
  Eigen::VectorXd aims_;
};

Eigen::MatrixXd random_matrix(int rows, int columns) {
  return Eigen::Map<const Eigen::MatrixXd>(draw_white(rows * columns, 5).eval().data(), rows, columns);
}

std::vector<double> evaluate(const SpanResiduals& small, const Eigen::VectorXd& y) {
  std::vector<double> residuals(std::size_t(small.num_residuals()));
  const double* parameters = y.data();
  EXPECT_TRUE(small.Evaluate(&parameters, residuals.data(), nullptr));
  return residuals;
}

// Residuals of a few radii by waves, about a random surface.
struct WaveCase {
  DiffractedScene scene{RadialPsd(UniformPsd{1, 4, 16}), 1.2, 36, 48};
  FitProblem problem = scene.problem({}, FocusModel::kWaves);
  Eigen::VectorXd start = draw_white(scene.prior.size(), 3), centre = draw_white(scene.prior.size(), 4);
  std::unique_ptr<FocusResiduals> residuals;

  WaveCase() {
    for (const double share : {0.3, 0.5, 0.8})
      problem.targets.push_back({EncircledEnergyRadius{share, 0}, 3 * scene.unit(), 0, 0.1 * scene.unit()});
    residuals = std::make_unique<FocusResiduals>(problem, scene.unit(), 1);
    Eigen::VectorXd at_start(3);
    EXPECT_TRUE(residuals->evaluate(start, true, at_start.data()));
  }
};

}  // namespace

TEST(SpanResiduals, OfALinearProblemOneStepLandsOnTheSolutionNearestToTheStart) {
  constexpr int kStatistics = 5, kTerms = 40;
  const Eigen::MatrixXd slopes = random_matrix(kStatistics, kTerms);
  const Eigen::VectorXd aims = draw_white(kStatistics, 7), start = draw_white(kTerms, 8);
  const LinearResiduals residuals(slopes, aims);
  Eigen::VectorXd here(kStatistics);
  ASSERT_TRUE(residuals.evaluate(start, true, here.data()));
  SpanResiduals small(residuals, start, 1e-9, 0, true);
  EXPECT_EQ(small.size(), kStatistics);  // xi0 is the centre, so no direction leads back to it

  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  Eigen::VectorXd y = small.start();
  problem.AddResidualBlock(&small, nullptr, y.data());
  ceres::Solver::Options options;
  options.max_num_iterations = 1;
  options.initial_trust_region_radius = 1e16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  const Eigen::VectorXd off = aims - slopes * start, nearest = start + LeastNorm(slopes).solve(off);
  EXPECT_LT((residuals.last().white - nearest).norm(), 1e-10 * nearest.norm());
}

TEST(SpanResiduals, AnEvaluationHasNoMemory) {
  const WaveCase of;
  const SpanResiduals small(*of.residuals, of.centre, 0.5, 0.1, true);
  const Eigen::VectorXd here = small.start() + 0.2 * draw_white(small.size(), 1),
                        there = small.start() + 0.4 * draw_white(small.size(), 2);
  const std::vector<double> first = evaluate(small, here), other = evaluate(small, there);
  EXPECT_NE(first, other);
  EXPECT_EQ(evaluate(small, there), other);
  evaluate(small, small.start());
  EXPECT_EQ(evaluate(small, here), first);
  // Another instance gives the same with calls in another order and derivatives in between.
  const WaveCase again;
  const SpanResiduals fresh(*again.residuals, again.centre, 0.5, 0.1, true);
  const double* parameters = there.data();
  std::vector<double> values(other.size()), slopes(other.size() * std::size_t(small.size()));
  double* jacobian = slopes.data();
  EXPECT_TRUE(fresh.Evaluate(&parameters, values.data(), &jacobian));
  EXPECT_EQ(values, other);
  EXPECT_EQ(evaluate(fresh, here), first);
}

TEST(SpanResiduals, GradientsMatchDifferences) {
  const WaveCase of;
  for (const bool bends : {false, true}) {
    const SpanResiduals small(*of.residuals, of.centre, 0.5, 0.1, bends);
    // Derivatives of bent steps are exact at the start only; their second difference has a hundred times the
    // rounding.
    const Eigen::VectorXd y = bends ? small.start() : small.start() + 0.3 * draw_white(small.size(), 1);
    const double precision = bends ? 1e-5 : 1e-7;
    ceres::NumericDiffOptions how;
    how.ridders_relative_initial_step_size = 1e-3;
    const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
    ceres::GradientChecker checker(&small, no_manifolds, how);
    const double* parameters = y.data();
    ceres::GradientChecker::ProbeResults results;
    checker.Probe(&parameters, 1e-3, &results);
    EXPECT_LT((results.jacobians[0] - results.numeric_jacobians[0]).cwiseAbs().maxCoeff(),
              precision * results.jacobians[0].cwiseAbs().maxCoeff())
        << bends;
  }
}

// Along a straight step without first-order change statistics change in second order, along a bent one in
// third.
TEST(SpanResiduals, BendsItsStepAsTheValleyDoes) {
  const WaveCase of;
  const auto change = [&](bool bends) {
    const SpanResiduals small(*of.residuals, of.centre, 1e-3, 0, bends);
    const int rows = small.num_residuals(), unknowns = small.size();
    Jacobian slopes(rows, unknowns);
    Eigen::VectorXd before(rows), after(rows), y = small.start();
    const double* parameters = y.data();
    double* jacobian = slopes.data();
    EXPECT_TRUE(small.Evaluate(&parameters, before.data(), &jacobian));
    const Eigen::MatrixXd of_statistics = slopes.topRows(3);
    const Eigen::VectorXd seen = of_statistics * y, unseen = y - LeastNorm(of_statistics).solve(seen);
    y += 0.3 * unseen.normalized();
    EXPECT_TRUE(small.Evaluate(&parameters, after.data(), nullptr));
    return (after - before).head(3).norm();
  };
  const double straight = change(false), bent = change(true);
  RecordProperty("bent_share_in_percent", int(100 * bent / straight));
  EXPECT_LT(bent, 0.3 * straight);
}
