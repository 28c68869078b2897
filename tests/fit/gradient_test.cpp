#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "../../src/fit/focus_residuals.h"
#include "fit_scene.h"
#include "short_form.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

// Every kind of statistic, in and out of focus. Planes scale with the spot, because defocus would hide a
// small one.
std::vector<Statistic> every_statistic(double focal_sigma) {
  const double dz = 2.8 / 0.2 * focal_sigma;
  return {EncircledEnergyRadius{0.2, 0},
          EncircledEnergyRadius{0.9, 0},
          EncircledEnergyRadius{0.5, 1.5 * dz},
          EncircledEnergyRadius{0.8, -1.5 * dz},
          RingFwhm{},
          RingFwhm{0.5, {}},
          RingFwhm{0.9, 2 * focal_sigma},
          RingThrough{focal_sigma, dz},
          ScatterRms{},
          ScatterMean{},
          SpotFwhm{0.3 * focal_sigma},
          RmsRadius{dz},
          RmsHeight{}};
}

std::vector<Target> targets_of(const std::vector<Statistic>& statistics, const FitScene& scene) {
  std::vector<Target> targets;
  for (const Statistic& s : statistics) {
    double unit = scene.focal_sigma;
    if (std::holds_alternative<ScatterRms>(s) || std::holds_alternative<ScatterMean>(s))
      unit = scene.focal_sigma / 2.8;
    if (std::holds_alternative<RingThrough>(s)) unit = 1.0;
    if (std::holds_alternative<RmsHeight>(s)) unit = 1e-7 * scene.focal_sigma / 3e-5;
    targets.push_back({s, unit, 0, unit});
  }
  return targets;
}

// Ridders differences of every residual against the analytic Jacobian. size: scale of the coordinates in
// prior standard deviations, which limits the steps.
void check_gradient(const FitScene& scene, const Eigen::VectorXd& white, double size, double width,
                    double precision) {
  const std::vector<Target> targets = targets_of(every_statistic(scene.focal_sigma), scene);
  for (const Target& target : targets) {
    const FitProblem problem = scene.problem({target});
    const FocusResiduals residual(problem, width * scene.focal_sigma, 1);
    ceres::NumericDiffOptions how;
    how.ridders_relative_initial_step_size = 1e-4 * size;  // also Ceres' smallest absolute step
    const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
    ceres::GradientChecker checker(&residual, no_manifolds, how);
    std::vector<const double*> blocks;
    Eigen::Index at = 0;
    for (const int length : residual.parameter_block_sizes()) {
      blocks.push_back(white.data() + at);
      at += length;
    }
    ceres::GradientChecker::ProbeResults results;
    checker.Probe(blocks.data(), precision, &results);
    ASSERT_TRUE(results.return_value) << statistic_name(target.statistic);
    // The scale is that of the whole gradient, because single entries may vanish.
    double largest = 0, error = 0;
    for (std::size_t b = 0; b < results.jacobians.size(); ++b) {
      largest = std::max(largest, results.jacobians[b].cwiseAbs().maxCoeff());
      error = std::max(error, (results.jacobians[b] - results.numeric_jacobians[b]).cwiseAbs().maxCoeff());
    }
    EXPECT_GT(largest, 0) << statistic_name(target.statistic);
    EXPECT_LT(error / largest, precision) << statistic_name(target.statistic);
  }
}

// The kernel has three continuous derivatives, so differences over some hundred rays are accurate to 1e-6.
constexpr double kPrecision = 5e-6;

}  // namespace

TEST_WITH_SHORT_FORM(FocusResiduals, GradientsHoldAtGenericPoints) {
  const FitScene scene(8, {4, 6}, 4000, PupilLayout::kRandom);
  for (const std::uint64_t seed : aberfit::test::all_or_few(whole, std::vector<std::uint64_t>{2, 3, 4}, {0}))
    check_gradient(scene, draw_white(scene.prior.size(), seed), 1.0, 0.3, kPrecision);
}

TEST(FocusResiduals, GradientsHoldAtAThousandthOfADraw) {
  FitScene scene(8, {4}, 4000, PupilLayout::kRandom);
  scene.focal_sigma *= 1e-3;  // the kernel follows the spot
  check_gradient(scene, 1e-3 * draw_white(scene.prior.size(), 2), 1e-3, 0.3, kPrecision);
}

TEST(FocusResiduals, GradientsHoldWithARayThroughTheCentreAndTiedRadii) {
  // With a polar pupil and a surface of revolution every ring of rays is tied. One more ray runs along the
  // axis.
  FitScene scene(4, {4}, 1200, PupilLayout::kPolar);
  const Eigen::Index n = scene.pupil.size();
  for (Eigen::ArrayXd* values : {&scene.pupil.x, &scene.pupil.y, &scene.pupil.weight})
    values->conservativeResize(n + 1);
  scene.pupil.x[n] = scene.pupil.y[n] = 0;
  scene.pupil.weight[n] = 1.0 / double(n);
  scene.surface = SurfaceOperator(scene.terms, scene.pupil.x, scene.pupil.y, 1);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(scene.terms.size());
  for (std::size_t j = 0; j < scene.terms.zernike.size(); ++j)
    if (scene.terms.zernike[j].m == 0) coefficients[Eigen::Index(j)] = 4e-8;
  const Eigen::Index size = scene.prior.size();
  Eigen::MatrixXd factor(size, size);
  for (Eigen::Index k = 0; k < size; ++k) factor.col(k) = scene.prior.colour(Eigen::VectorXd::Unit(size, k));
  const Eigen::VectorXd white = factor.completeOrthogonalDecomposition().solve(coefficients);
  check_gradient(scene, white, 1.0, 0.8, kPrecision);
}

TEST(Calibrate, ZeroCoefficientsAreDegenerate) {
  const FitScene scene(4, {}, 1000, PupilLayout::kPolar);
  const FitProblem problem = scene.problem({{EncircledEnergyRadius{0.9, 0}, 3e-5, 0, 3e-8}});
  const FitResult result = calibrate(problem, Eigen::VectorXd::Zero(scene.prior.size()), {});
  EXPECT_EQ(result.status, FitStatus::kDegenerate);
  EXPECT_FALSE(result.message.empty());
}
