#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

#include "aberfit/theory/regime.h"
#include "diffracted_scene.h"
#include "gradient_check.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

// Derivatives of diffraction are accurate to 1e-8 (diffraction_gradient_test.cpp); Ridders differences of a
// search through focus reach ten times that.
constexpr double kStep = 1e-3;  // in prior standard deviations
constexpr double kPrecision = 1e-7;

std::vector<Target> with_tolerance(const std::vector<Statistic>& statistics, const Eigen::VectorXd& values,
                                   double tolerance) {
  std::vector<Target> targets;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const double value = values[Eigen::Index(k)];
    targets.push_back({statistics[k], value, 0, tolerance * std::abs(value)});
  }
  return targets;
}

// Targets of the mean irradiance of the PSD, by generalised Harvey-Shack.
std::vector<Target> mean_targets(const DiffractedScene& scene, const std::vector<Statistic>& statistics,
                                 double tolerance) {
  const GeneralisedHarveyShack mean(scene.psd, scene.mirror, scene.aperture, scene.wavelength);
  Eigen::VectorXd values(Eigen::Index(statistics.size()));
  for (std::size_t k = 0; k < statistics.size(); ++k) values[Eigen::Index(k)] = mean(statistics[k]);
  return with_tolerance(statistics, values, tolerance);
}

}  // namespace

TEST(WaveForward, GradientsOfTheWholeChainMatchDifferences) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 2, 8}), 1.2, 24, 32);
  const double unit = scene.unit(), dz = 30 * unit;
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.2, 0},
                                          EncircledEnergyRadius{0.8, 0},
                                          EncircledEnergyRadius{0.5, dz},
                                          RingThrough{1.5 * unit, -dz},
                                          RingFwhm{0.6, {}},
                                          RingFwhm{0.9, 2 * unit},
                                          SpotFwhm{0.3 * unit},
                                          ScatterRms{},

                                          RmsHeight{}};
  for (const Statistic& statistic : statistics) {
    const double size = std::holds_alternative<RmsHeight>(statistic)     ? 1e-8
                        : std::holds_alternative<ScatterRms>(statistic)  ? 1e-6
                        : std::holds_alternative<RingThrough>(statistic) ? 1
                        : std::holds_alternative<RingFwhm>(statistic)    ? dz
                                                                         : unit;
    const FitProblem problem = scene.problem({{statistic, 0, 0, size}}, FocusModel::kWaves);
    const FocusResiduals residual(problem, unit, 1);
    // The ends of a ring's width are found to 1e-10, which steps of 1e-3 amplify; largest error seen 6.5e-7.
    const double precision = std::holds_alternative<RingFwhm>(statistic) ? 1e-6 : kPrecision;
    EXPECT_LT(gradient_error(residual, draw_white(scene.prior.size(), 2), kStep), precision)
        << statistic_name(statistic);
  }
}

TEST(WaveForward, SaysOnceThatASurfaceIsTooSteepForItsGrid) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.5, 24, 64);
  const Eigen::VectorXd steep = 1000 * scene.prior.colour(draw_white(scene.prior.size(), 3));
  Warnings warnings;
  const Eigen::VectorXd values = focus_statistics(
      scene.path(FocusModel::kWaves), steep,
      {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.9, 0}, EncircledEnergyRadius{0.9, 1e-4}}, 1,
      &warnings);
  EXPECT_TRUE(values.array().isNaN().all());
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "psf-aliased");
  EXPECT_NE(warnings[0].message.find("and 2 more"), std::string::npos) << warnings[0].message;
}

TEST(WaveForward, AMirrorThatIsNoParabolaIsASurfaceErrorOfOne) {
  // The same shape is once the mirror, once a term: rho^4 of a spherical mirror and of a spherical term.
  DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.5, 24, 64);
  TermSet terms = scene.surface.terms();
  terms.spherical = {4};
  const SurfaceOperator surface(terms, scene.pupil.sample, {});
  Eigen::VectorXd coefficients(terms.size());
  coefficients.setZero();
  coefficients.head(scene.prior.size()) = scene.prior.colour(draw_white(scene.prior.size(), 3));
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.9, 1e-4}};
  LightPath plain = scene.path(FocusModel::kWaves);
  LightPath term{scene.mirror, scene.pupil.sample, surface, plain.model, plain.wavelength, plain.aperture};
  constexpr double kC4 = 1e-5;  // [1/m^3]; 16 nm at the rim
  // The operator gives the basis of the coefficient: height at the rim per unit.
  Eigen::VectorXd only = Eigen::VectorXd::Zero(terms.size());
  only[terms.size() - 1] = 1;
  SurfaceField field;
  surface.apply(only, &field);
  const double rho2 =
      scene.pupil.sample.x[0] * scene.pupil.sample.x[0] + scene.pupil.sample.y[0] * scene.pupil.sample.y[0];
  coefficients[terms.size() - 1] = kC4 * rho2 * rho2 / field.height[0];
  Mirror bent = scene.mirror;
  bent.spherical[0] = kC4;
  const LightPath as_mirror{bent,        scene.pupil.sample, scene.surface,
                            plain.model, plain.wavelength,   plain.aperture};
  const Eigen::VectorXd a = focus_statistics(term, coefficients, statistics, 1, nullptr);
  const Eigen::VectorXd b =
      focus_statistics(as_mirror, coefficients.head(scene.prior.size()), statistics, 1, nullptr);
  const Eigen::VectorXd c =
      focus_statistics(plain, coefficients.head(scene.prior.size()), statistics, 1, nullptr);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(a[k] / b[k], 1, 1e-9);  // rounding of phases of 1e6 rad
    EXPECT_GT(std::abs(a[k] / c[k] - 1), 1e-3);
  }
}

TEST(Calibrate, MeetsTheMeanOfWavesAtHalfAWaveOfPhase) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 5, 30}), 0.5, 700, 128, 2);
  const SceneNumbers regime = scene_numbers(scene.psd, scene.mirror, scene.aperture, scene.wavelength);
  ASSERT_LT(regime.kappa, 0.85);  // waves, not rays
  ASSERT_GT(regime.n_eff, 100);
  std::vector<Statistic> statistics;
  for (const double p : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
    for (const double dz : {0.0, -2e-4, 2e-4}) statistics.push_back(EncircledEnergyRadius{p, dz});
  statistics.push_back(RmsHeight{});
  const FitProblem problem = scene.problem(mean_targets(scene, statistics, 1e-3), FocusModel::kWaves);
  FitOptions options;
  options.threads = 2;
  const FitResult result = calibrate(problem, draw_white(scene.prior.size(), 6), options);
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_TRUE(within_tolerance(problem, result, 1)) << result.message;
  RecordProperty("iterations", result.iterations);
  RecordProperty("evaluations", result.evaluations);
  RecordProperty("milliseconds", int(1e3 * result.seconds));
  RecordProperty("message", result.message);

  // An independent pattern on finer grid cells.
  const DiffractionPupil finer = diffraction_pupil(scene.aperture, scene.mirror.focal_length, 0.4 / 213);
  const SurfaceOperator surface(scene.surface.terms(), finer.sample, {});
  SurfaceField field;
  surface.apply(result.coefficients, &field);
  DiffractionProblem again{finer, scene.mirror.focal_length, scene.wavelength};
  Eigen::VectorXd values;
  const std::vector<Statistic> of_irradiance(statistics.begin(), statistics.end() - 1);
  ASSERT_TRUE(evaluate_diffraction(again, field.height, of_irradiance, 2, nullptr, &values, nullptr));
  // The height, the last of the statistics, is a property of the surface and summed here.
  const Eigen::ArrayXd weight = finer.sample.weight / finer.sample.weight.sum();
  const double mean = (weight * field.height).sum();
  values.conservativeResize(Eigen::Index(statistics.size()));
  values[values.size() - 1] = std::sqrt((weight * (field.height - mean).square()).sum());
  constexpr double kAgreement = 5e-3;  // of a target
  double worst = 0;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const double off = values[Eigen::Index(k)] / problem.targets[k].value - 1;
    worst = std::max(worst, std::abs(off));
    EXPECT_LT(std::abs(off), kAgreement) << statistic_name(statistics[k]);
  }
  RecordProperty("worst_in_1e-6", int(1e6 * worst));
}

// The target is so loose that the fit could end long before its guide is near. The start gives the largest
// residual of a target in tolerances, and of a guide in the required part of its own.
TEST(Calibrate, CountsGuidesByTheShareOfTheirToleranceThatIsWanted) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 24, 32);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, RingThrough{8e-6, 2e-4}};
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 5);
  const Eigen::VectorXd at_start =
      focus_statistics(scene.path(FocusModel::kWaves), scene.prior.colour(start), statistics, 1, nullptr);
  FitProblem problem = scene.problem({{statistics[0], at_start[0] + 3e-8, 0, 1e-8}}, FocusModel::kWaves);
  problem.guides = {{statistics[1], at_start[1] - 2e-4, 0, 1e-4}};
  for (const auto& [within, mismatch] : {std::pair{0.0, 3.0}, {1.0, 3.0}, {0.5, 4.0}, {0.25, 8.0}}) {
    double first = 0;
    FitOptions options;
    options.guides_within = within;
    options.progress = [&](const FitProgress& progress) { return first = progress.worst_mismatch, false; };
    calibrate(problem, start, options);
    EXPECT_NEAR(first, mismatch, 1e-5 * mismatch) << within;
  }
}

TEST(Calibrate, GoesOnForItsGuidesWhereItIsToldTo) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 60, 48);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, RingThrough{8e-6, 2e-4}};
  const Eigen::VectorXd other =
      focus_statistics(scene.path(FocusModel::kWaves), scene.prior.colour(draw_white(scene.prior.size(), 9)),
                       statistics, 1, nullptr);
  FitProblem problem = scene.problem({{statistics[0], other[0], 0, 0.2 * other[0]}}, FocusModel::kWaves);
  Target guide;
  guide.statistic = statistics[1];
  guide.value = other[1];
  guide.tolerance = 1e-4;
  problem.guides = {guide};
  const auto guide_after = [&](double within) {
    FitOptions options;
    options.stop_at = 1;
    options.guides_within = within;
    const FitResult fit = calibrate(problem, draw_white(scene.prior.size(), 5), options);
    EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
    const Eigen::VectorXd values =
        focus_statistics(scene.path(FocusModel::kWaves), fit.coefficients, statistics, 1, nullptr);
    return std::abs(values[1] - guide.value) / guide.tolerance;
  };
  ASSERT_GT(guide_after(0), 2) << "nothing tested";
  EXPECT_LE(guide_after(1), 1 + 1e-6);
  EXPECT_LE(guide_after(0.1), 0.1 + 1e-6);
}

// With and without acceleration the fit meets the tolerances from a start with about 1 rad of phase. The
// accelerated steps follow the bend and need fewer iterations.
void follows_the_bend(const FitProblem& problem, const Eigen::VectorXd& start) {
  const auto fit = [&](bool accelerate) {
    FitOptions options;
    options.threads = 2;
    options.stop_at = 1;
    options.prior_weight = 0.1;
    options.accelerate = accelerate;
    const FitResult result = calibrate(problem, start, options);
    EXPECT_TRUE(within_tolerance(problem, result, 1)) << result.message;
    return result;
  };
  const FitResult straight = fit(false), along = fit(true);
  testing::Test::RecordProperty("straight", straight.iterations);
  testing::Test::RecordProperty("along", along.iterations);
  EXPECT_LT(along.iterations, 0.7 * straight.iterations);
}

std::vector<Statistic> forty_radii() {
  std::vector<Statistic> statistics;
  for (const double p : {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9})
    for (const double dz : {0.0, -1e-4, 1e-4, -2e-4, 2e-4})
      statistics.push_back(EncircledEnergyRadius{p, dz});
  return statistics;
}

TEST(Calibrate, FollowsTheBendOfTheValleyOfFarMoreTermsThanStatistics) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 40}), 1.2, 700, 96, 2);
  follows_the_bend(scene.problem(mean_targets(scene, forty_radii(), 1e-3), FocusModel::kWaves),
                   draw_white(scene.prior.size(), 6));
}

TEST(Calibrate, FollowsTheBendOfTheValleyOfFewerTermsThanStatistics) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 1.2, 36, 64, 2);
  const Eigen::VectorXd other =
      focus_statistics(scene.path(FocusModel::kWaves), scene.prior.colour(draw_white(scene.prior.size(), 9)),
                       forty_radii(), 1, nullptr);
  follows_the_bend(scene.problem(with_tolerance(forty_radii(), other, 1e-3), FocusModel::kWaves),
                   draw_white(scene.prior.size(), 6));
}

TEST(Calibrate, FitsWavesWithTheSameBitsForAnyThreadCount) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 60, 48);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 2e-4},
                                          RingFwhm{}, RmsHeight{}, ScatterRms{}};
  const Eigen::VectorXd other =
      focus_statistics(scene.path(FocusModel::kWaves), scene.prior.colour(draw_white(scene.prior.size(), 9)),
                       statistics, 1, nullptr);
  const FitProblem problem = scene.problem(with_tolerance(statistics, other, 1e-3), FocusModel::kWaves);
  FitOptions one, three;
  three.threads = 3;
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 3);
  const FitResult a = calibrate(problem, start, one), b = calibrate(problem, start, three);
  EXPECT_EQ(a.status, FitStatus::kConverged) << a.message;
  EXPECT_TRUE(within_tolerance(problem, a, 1)) << a.message;
  EXPECT_TRUE(a.coefficients == b.coefficients);
  EXPECT_GT(a.iterations, 1);
}

TEST(Calibrate, SaysWhyWavesCannotMeetATarget) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 24, 32);
  const double unit = scene.unit();
  const auto fit = [&](const Statistic& statistic, double value, bool zero = false) {
    const FitProblem problem = scene.problem({{statistic, value, 0, 1e-3 * value}}, FocusModel::kWaves);
    Eigen::VectorXd start = draw_white(scene.prior.size(), 3);
    if (zero) start.setZero();
    return calibrate(problem, start, {});
  };
  const FitResult below = fit(EncircledEnergyRadius{0.8, 0}, 0.5 * unit);
  EXPECT_EQ(below.status, FitStatus::kDegenerate);
  EXPECT_NE(below.message.find("diffraction of the aperture allows no less"), std::string::npos)
      << below.message;
  const FitResult beyond = fit(EncircledEnergyRadius{0.8, 0}, 20 * unit);
  EXPECT_EQ(beyond.status, FitStatus::kDegenerate);
  EXPECT_NE(beyond.message.find("field of view"), std::string::npos) << beyond.message;
  const FitResult moment = fit(RmsRadius{}, unit);
  EXPECT_EQ(moment.status, FitStatus::kDegenerate);
  EXPECT_NE(moment.message.find("diverges"), std::string::npos) << moment.message;
  const FitResult perfect = fit(EncircledEnergyRadius{0.8, 0}, 2 * unit, true);
  EXPECT_EQ(perfect.status, FitStatus::kDegenerate);
  EXPECT_NE(perfect.message.find("first order"), std::string::npos) << perfect.message;

  Warnings warnings;
  const Eigen::VectorXd values =
      focus_statistics(scene.path(FocusModel::kWaves), Eigen::VectorXd::Zero(scene.prior.size()),
                       {RmsRadius{}, RingThrough{1, 0}, RmsHeight{}}, 1, &warnings);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_TRUE(std::isnan(values[1]));
  EXPECT_EQ(values[2], 0);
  EXPECT_EQ(warnings.size(), 2u);
}

TEST(FocusStatistics, SaysThatASurfaceThatIsNotFiniteHasNoPsf) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 24, 32);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(scene.prior.size());
  coefficients[3] = std::nan("");
  Warnings warnings;
  const Eigen::VectorXd values =
      focus_statistics(scene.path(FocusModel::kWaves), coefficients, {EncircledEnergyRadius{}}, 1, &warnings);
  EXPECT_TRUE(std::isnan(values[0]));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "psf-not-finite");
}

TEST(FocusStatistics, RefusesPathsThatAModelCannotTreat) {
  const DiffractedScene scene(RadialPsd(UniformPsd{1, 4, 16}), 0.8, 24, 32);
  const Eigen::VectorXd flat = Eigen::VectorXd::Zero(scene.prior.size());
  const auto statistics_of = [&](const LightPath& at) {
    return focus_statistics(at, flat, {EncircledEnergyRadius{}}, 1, nullptr);
  };
  LightPath dark = scene.path(FocusModel::kWaves), open = dark, centroid = dark;
  dark.wavelength = 0;
  open.aperture = nullptr;
  centroid.centre = Centre::kCentroid;
  EXPECT_THROW(statistics_of(dark), std::invalid_argument);
  EXPECT_THROW(statistics_of(open), std::invalid_argument);
  EXPECT_THROW(statistics_of(centroid), std::invalid_argument);
  const PupilSample polar = make_pupil(scene.aperture, {PupilLayout::kPolar, 1000, 1});
  const SurfaceOperator surface(scene.surface.terms(), polar, {});
  EXPECT_THROW(
      statistics_of({scene.mirror, polar, surface, FocusModel::kWaves, scene.wavelength, &scene.aperture}),
      std::invalid_argument);
}
