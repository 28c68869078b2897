#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "diffracted_scene.h"
#include "gradient_check.h"

using namespace aberfit;

namespace {

constexpr double kStep = 1e-3;       // of a draw
constexpr double kPrecision = 1e-7;  // see wave_fit_test.cpp

std::vector<Statistic> every_statistic(double unit, double dz) {
  return {EncircledEnergyRadius{0.2, 0},
          EncircledEnergyRadius{0.8, 0},
          EncircledEnergyRadius{0.5, dz},
          RingThrough{3 * unit, -dz},
          RingFwhm{0.6, {}},
          RingFwhm{0.9, 4 * unit},
          SpotFwhm{6 * unit},
          ScatterRms{},
          RmsHeight{}};
}

}  // namespace

TEST(ConvolvedForward, GradientsOfTheWholeChainMatchDifferences) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 2, 6}), 3, 24, 40);
  const double unit = scene.unit(), dz = 60 * unit;
  for (const Statistic& statistic : every_statistic(unit, dz)) {
    const double size = std::holds_alternative<RmsHeight>(statistic)     ? 1e-8
                        : std::holds_alternative<ScatterRms>(statistic)  ? 1e-6
                        : std::holds_alternative<RingThrough>(statistic) ? 1
                        : std::holds_alternative<RingFwhm>(statistic)    ? dz
                                                                         : unit;
    const FitProblem problem = scene.problem({{statistic, 0, 0, size}}, FocusPhysics::kConvolved);
    const FocusResiduals residual(problem, unit, 1);
    EXPECT_LT(gradient_error(residual, draw_white(scene.prior.size(), 2), kStep), kPrecision)
        << statistic_name(statistic);
  }
}

TEST(Calibrate, MeetsTheMeanOfConvolvedRaysWithTheSameBitsForAnyThreadCount) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 5, 30}), 3, 300, 64);
  GhsOptions rays;
  rays.surface = SurfaceModel::kRays;
  const GeneralisedHarveyShack mean(scene.psd, scene.mirror, scene.aperture, scene.wavelength, rays);
  std::vector<Target> targets;
  for (const double p : {0.2, 0.5, 0.8, 0.95})
    targets.push_back({EncircledEnergyRadius{p, 0}, mean.encircled_energy_radius(p, 0), 0,
                       1e-3 * mean.encircled_energy_radius(p, 0)});
  targets.push_back({ScatterRms{}, mean.scatter_rms(), 0, 1e-3 * mean.scatter_rms()});
  const FitProblem problem = scene.problem(targets, FocusPhysics::kConvolved);
  FitOptions one, three;
  three.threads = 3;
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 3);
  const FitResult a = calibrate(problem, start, one), b = calibrate(problem, start, three);
  EXPECT_EQ(a.status, FitStatus::kConverged) << a.message;
  EXPECT_TRUE(within_tolerance(problem, a, 1)) << a.message;
  EXPECT_TRUE(a.coefficients == b.coefficients);
  RecordProperty("iterations", a.iterations);
  RecordProperty("milliseconds", int(1e3 * a.seconds));
}

TEST(FocusStatistics, OfConvolvedRaysOfAPerfectMirrorAreThePatternsOwn) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 1, 24, 40);
  const Eigen::VectorXd flat = Eigen::VectorXd::Zero(scene.prior.size());
  Warnings warnings;
  const Eigen::VectorXd radius = focus_statistics(scene.scene(FocusPhysics::kConvolved), flat,
                                                  {EncircledEnergyRadius{0.5, 0}}, 1, &warnings);
  const double z = std::numbers::pi * radius[0] / scene.unit();
  const double j0 = boost::math::cyl_bessel_j(0, z), j1 = boost::math::cyl_bessel_j(1, z);
  EXPECT_NEAR(1 - j0 * j0 - j1 * j1, 0.5, 1e-9);  // Airy
  EXPECT_TRUE(warnings.empty());
  focus_statistics(scene.scene(FocusPhysics::kConvolved), flat, {EncircledEnergyRadius{0.5, 2e-4}}, 1,
                   &warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "convolved-defocus");
  // Nothing to follow there, and no spot below the pattern.
  const double above = 2 * radius[0], below = 0.8 * radius[0];
  const FitResult stuck = calibrate(
      scene.problem({{EncircledEnergyRadius{0.5, 0}, above, 0, 1e-3 * above}}, FocusPhysics::kConvolved),
      flat, {});
  EXPECT_EQ(stuck.status, FitStatus::kDegenerate) << stuck.message;
  const FitResult low = calibrate(
      scene.problem({{EncircledEnergyRadius{0.5, 0}, below, 0, 1e-3 * below}}, FocusPhysics::kConvolved),
      draw_white(scene.prior.size(), 3), {});
  EXPECT_EQ(low.status, FitStatus::kDegenerate) << low.message;
}
