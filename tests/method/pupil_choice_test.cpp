// Where waves may look less closely: circles that are wide, and single precision.
#include "aberfit/method/pupil_choice.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fresh_verdict.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/study/read_study.h"
#include "aberfit/terms/modal_covariance.h"
#include "short_form.h"

namespace aberfit {
namespace {

Study study_of(const std::string& rms, const std::string& target = "{}", const std::string& margin = "1 %") {
  return parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "2.8 m"}},
        "aperture": {{"shape": "circle", "diameter": "0.4 m"}}, "light": {{"wavelength": "632.8 nm"}},
        "roughness": {{"psd": {{"model": "uniform", "rms": "{}", "f_min": "2.5 /m", "f_max": "13 /m"}}}},
        "target": {}, "terms": {{"band": "all"}}, "equivalence": {{"margin": "{}"}}}})",
                                 rms, target, margin),
                     "study.json");
}

// Uniform roughness of g = 4: the core has exp(-16) of the light; of g = 2 a fiftieth.
TEST(WideCircles, AreThereWhereThePatternHasNoCoreAndByTheMargin) {
  const auto grains = [](const std::string& rms, const std::string& target = "{}",
                         const std::string& margin = "1 %",
                         std::optional<double> stray_light = std::nullopt) {
    Study study = study_of(rms, target, margin);
    study.equivalence.stray_light = stray_light;
    const Groundwork ground = lay_groundwork(study);
    return grains_of(study, wide_circles(study, ground, make_targets(study, ground, 1)));
  };
  const double at_one_percent = grains("200 nm");
  EXPECT_NEAR(kWideCircleNoise * std::pow(at_one_percent, -1.5), law::kWideShareOfMargin * 0.01, 1e-12);
  EXPECT_NEAR(grains("200 nm", "{}", "0.3 %") / at_one_percent, std::pow(1 / 0.3, 2.0 / 3), 1e-9);
  // Of the light outside ee95 a hundredth is a smaller margin: 5e-4 over r dE/dr, about 0.3 there.
  EXPECT_GT(grains("200 nm", "{}", "1 %", 0.01), 2 * at_one_percent);
  EXPECT_EQ(grains("100 nm"), HUGE_VAL);
  EXPECT_EQ(grains("200 nm", R"({"theory": "geometric"})"), HUGE_VAL);
}

// A rough mirror of 0.4 m at f/7, uniform PSD from 5 /m on.
Study rough_mirror(const char* aperture, double rms_nm, double f_max) {
  return parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "2.8 m"}}, "aperture": {},
                                      "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{
                                      "model": "uniform", "rms": "{} nm", "f_min": "5 /m", "f_max": "{} /m"
                                      }}}}}})",
                                 aperture, rms_nm, f_max),
                     "study.json");
}

// What light once a grain changes of the light in circles of these radii, in the root mean square of draws of
// terms that keep `core` of the light in their core.
Eigen::VectorXd departure_of_wide_circles(const Study& study, const Groundwork& ground, double core,
                                          int cells, const std::vector<double>& grains) {
  // Uniform: the height below a cut goes with the area of its band, and leaves exp(-g^2) in the core.
  const double g = ground.numbers.g, low = ground.psd->f_min() * ground.psd->f_min(),
               band = ground.psd->f_max() * ground.psd->f_max() - low;
  const double cut = std::sqrt(low + band * -std::log(core) / (g * g));
  const auto split = std::make_shared<const BandSplit>(*ground.psd, cut, study.mirror, study.aperture,
                                                       study.wavelength, ground.mean_spot);
  TermSet waves;
  waves.radius = ground.radius;
  waves.fourier_pitch = 1 / (2 * ground.radius);
  waves.fourier = fourier_lattice(split->low(), waves.fourier_pitch);
  const CoefficientPrior prior(waves.size(), make_prior(waves, split->low(), CovarianceKind::kFull).blocks());
  std::vector<Statistic> circles;
  for (const double of : grains)
    circles.push_back(RingThrough{of * study.wavelength / 0.4 * study.mirror.focal_length});
  constexpr int kDraws = 8;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(Eigen::Index(grains.size()));
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    const Eigen::VectorXd coefficients = prior.colour(draw_white(prior.size(), draw));
    const auto seen = [&](double wide) {
      Workbench bench(study, FocusModel::kWaves, PupilOptions{}, 0.4 / cells, waves, 2, split);
      bench.wide_circles = wide;
      return bench.exact(study, coefficients, circles, 2, nullptr);
    };
    squares += (seen(0) - seen(HUGE_VAL)).cwiseAbs2();
  }
  return (squares / kDraws).cwiseSqrt();
}

// Long lags of surfaces whose pattern has a core come back to short ones, and the scatter that takes the core
// off smooths what they do: of mirrors whose terms keep a twohundredth to nine tenths of the light in their
// core, wide circles are within two fifths of the noise that they are allowed.
TEST_WITH_SHORT_FORM(WideCircles, AreAsGoodWhereScatterTakesOffTheCore) {
  const std::vector<double> grains = {43, 100, 200};
  for (const double rms : {136.0, 170.0, 260.0})  // g 2.7, of which 7e-4 are left, 3.4 and 5.2
    for (const double core : {0.005, 0.3, 0.9}) {
      if (!whole && (core < 0.1 || (core < 0.5) != (rms < 150) || rms > 200)) continue;
      const Study study = rough_mirror(R"({"shape": "circle", "diameter": "0.4 m"})", rms, 120);
      const Groundwork ground = lay_groundwork(study);
      EXPECT_FALSE(ground.has_core());
      const Eigen::VectorXd off = departure_of_wide_circles(study, ground, core, 512, grains);
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double noise = kWideCircleNoise * std::pow(grains[std::size_t(k)], -1.5);
        EXPECT_LT(off[k], 0.4 * noise)
            << rms << " nm, core " << core << ", " << grains[std::size_t(k)] << " grains";
        EXPECT_GT(off[k], 0);  // they are wide
      }
    }
}

// The transfer function of a square ends in a straight line and that of a thin annulus in a peak: their
// longest lags must not come back to the shortest, where the scatter has taken nothing off.
TEST_WITH_SHORT_FORM(WideCircles, OfSquaresAndThinAnnuliAreAsGood) {
  const std::vector<double> grains = {60, 100, 200};
  struct Shape {
    const char* aperture;
    double f_max;
  };
  const std::vector<Shape> shapes{
      Shape{R"({"shape": "rectangle", "width": "0.4 m", "height": "0.4 m"})", 60},
      Shape{R"({"shape": "rectangle", "width": "0.4 m", "height": "0.4 m"})", 40},
      Shape{R"({"shape": "annulus", "diameter": "0.4 m", "inner_diameter": "0.36 m"})", 40}};
  for (const Shape& shape : aberfit::test::all_or_few(whole, shapes, {1, 2})) {
    const Study study = rough_mirror(shape.aperture, 170, shape.f_max);
    const Groundwork ground = lay_groundwork(study);
    for (const int cells : aberfit::test::all_or_few(whole, std::vector{256, 384}, {0})) {
      const Eigen::VectorXd off = departure_of_wide_circles(study, ground, 0.9, cells, grains);
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double noise = kWideCircleNoise * std::pow(grains[std::size_t(k)], -1.5);
        EXPECT_LT(off[k], 0.4 * noise)
            << shape.aperture << ' ' << shape.f_max << ' ' << cells << ", " << grains[std::size_t(k)];
      }
    }
  }
}

// 93 grains at a margin of 3 %: wide, and twice its noise is in the error beside what grids differ by.
TEST(WideCircles, EnterTheErrorOfAVerdict) {
  constexpr double kRadius = 0.413e-3;
  const Study study = study_of(
      "1 um",
      fmt::format(
          R"({{"theory": "ghs", "statistics": {{"ee80": {{"value": {}}}, "ee95": {{"value": 0.9e-3}}}}}})",
          kRadius),
      "3 %");
  const Layout layout = lay_out(study, 1);
  ASSERT_EQ(layout.ground.use.model, FocusModel::kWaves);
  const RunContext context{2};
  const FitCase of{study, layout.ground, layout.targets, context};
  const double wide = wide_circles(study, layout.ground, layout.targets);
  ASSERT_GT(kRadius / 2.8, wide);
  Attempt attempt;
  attempt.result.terms.radius = 0.2;
  attempt.result.terms.zernike = zernike_modes(2, 12);
  const CoefficientPrior prior = make_prior(attempt.result.terms, *layout.ground.psd, CovarianceKind::kFull);
  attempt.result.fit.coefficients = prior.colour(draw_white(prior.size(), 3));
  const double pitch = wave_pitch(study, attempt.result.terms, all_targets(layout.targets), nullptr, 2);
  attempt.bench = std::make_shared<const Workbench>(study, FocusModel::kWaves, PupilOptions{}, 2 * pitch,
                                                    attempt.result.terms, 1);
  judge_on_fresh_rays(of, &attempt);
  ASSERT_NE(attempt.result.verdict, Verdict::kUndecided);  // wide circles have decided
  const JudgedSet judged(layout.targets.fitted, layout.targets.held_out);
  const FreshStatistics grids = statistics_with_error(
      lit_mirror(study, nullptr),
      {FocusModel::kWaves, 0, 1,
       wave_pitch(study, attempt.result.terms, all_targets(layout.targets), nullptr,
                  attempt.judging_coarsening),
       wide, true},
      attempt.result.terms, attempt.result.fit.coefficients, judged.statistics(), 2, nullptr);
  const Eigen::VectorXd more = judged.judged(attempt.fresh.standard_error - grids.standard_error);
  const double scale = aim_of(layout.targets.fitted[0]).relative_to();
  EXPECT_NEAR(more[0], 2 * kWideCircleNoise * std::pow(grains_of(study, kRadius / 2.8), -1.5) * scale, 1e-12);
}

// On many cells, and unless a tolerance is near the rounding.
TEST(SinglePrecision, IsForFitsOnManyCells) {
  const auto fits = [](FocusModel model, Eigen::Index cells, double tolerance) {
    TargetSets targets;
    targets.fitted = {{EncircledEnergyRadius{0.8, 0}, 2e-5, 0, 0.01 * 2e-5},
                      {EncircledEnergyRadius{0.5, 0}, 1e-5, 0, tolerance * 1e-5}};
    EXPECT_EQ(judged_in_single_precision(0.01, targets), tolerance >= 1e-4);
    EXPECT_FALSE(judged_in_single_precision(HUGE_VAL, targets));
    return in_single_precision(model, targets, cells);
  };
  EXPECT_TRUE(fits(FocusModel::kWaves, law::kManyCells, 1.01e-4));
  EXPECT_FALSE(fits(FocusModel::kWaves, law::kManyCells - 1, 1.01e-4));
  EXPECT_FALSE(fits(FocusModel::kWaves, law::kManyCells, 0.99e-4));
  EXPECT_FALSE(fits(FocusModel::kRays, law::kManyCells, 1.01e-4));
}

TEST(WavePitch, SaysWhatAsksForAGridThatNoMemoryHolds) {
  const auto why = [](const std::string& text) {
    try {
      run_fit(parse_study(text, "study.json"), {});
    } catch (const ComputationError& error) {
      return std::string(error.what());
    } catch (const InputError& error) {  // of the number that can hardly be meant
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string scene = R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": )"
                            R"("circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"}, )";
  const std::string far =
      why(scene + R"("roughness": {"psd": {"model": "uniform", "rms": "25 nm", "f_min": )"
                  R"("2.5 /m", "f_max": "20 /m"}}, "terms": {"band": "all"}, "target": {"statistics": )"
                  R"({"ee50": {"value": "1 m"}}}})");
  EXPECT_NE(far.find("1.5 m from the axis"), std::string::npos) << far;
  const std::string fine =
      why(scene + R"("roughness": {"psd": {"model": "uniform", "rms": "1 nm", "f_min": )"
                  R"("2.5 /m", "f_max": "20 /mm"}}, "terms": {"fourier": {"count": 9}}})");
  EXPECT_NE(fine.find("cells across the aperture, more than 16384"), std::string::npos) << fine;
  std::string planes;  // of light that is all scatter: none of it asks for room
  try {
    wave_pitch(study_of("100 nm"), TermSet{0.2, {}, {}, {}}, {Target{EncircledEnergyRadius{0.5, 1.0}, 1e-3}},
               nullptr);
  } catch (const ComputationError& error) {
    planes = error.what();
  }
  EXPECT_NE(planes.find("16384: planes up to 1 m out of focus ask for it; take"), std::string::npos)
      << planes;
}

}  // namespace
}  // namespace aberfit
