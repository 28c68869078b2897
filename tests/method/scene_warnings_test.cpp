// Warnings of a specification, a trace and a comparison of branches, before any fit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/units.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/specified_light.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/method/verify.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2, kRadius = 0.2;

std::string study_of(const std::string& rest, const std::string& wavelength = "632.8 nm") {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2 m"}, "light": {"wavelength": ")" + wavelength +
         R"("}, "aperture": {"shape": "circle", "diameter": "0.4 m"})" + rest + "}";
}
const std::string kValue = R"(, "target": {"statistics": {"ee50": {"value": "20 um"}}},
                               "fit": {"prior": "zero-mean"})";
const std::string kSmooth =
    R"(, "roughness": {"psd": {"model": "uniform", "rms": "1 nm", "f_min": "2.5 /m", "f_max": "5 /m"}})";

// Message of the warning `code`; empty when there is none.
std::string message(const Warnings& warnings, const std::string& code) {
  for (const Warning& warning : warnings)
    if (warning.code == code) return warning.message;
  return "";
}
bool has(const std::string& text, const std::string& word) { return text.find(word) != std::string::npos; }

TEST(SceneWarnings, DiagonalCovariancePilesSlopesUpAtTheRim) {
  const auto said = [](const std::string& covariance) {
    const Study study = parse_study(
        study_of(kValue + R"(, "terms": {"zernike": {"n_max": 3}, "covariance": ")" + covariance + "\"}"),
        "study.json");
    const Groundwork ground = lay_groundwork(study);
    const TermPlan plan = plan_terms(study, ground, study.terms);
    return message(scene_warnings(study, ground, plan.terms, plan.captured), "diagonal-covariance");
  };
  EXPECT_TRUE(has(said("diagonal"), "at the rim")) << said("diagonal");
  EXPECT_EQ(said("full"), "");
}

TEST(SceneWarnings, TruncatedTermsHaveARemedyOfTheirKind) {
  const std::string rough =
      R"(, "roughness": {"psd": {"model": "uniform", "rms": "50 nm", "f_min": "2.5 /m", "f_max": "20 /m"}})";
  const auto said = [&](const std::string& terms) {
    const Study study = parse_study(study_of(rough + terms), "study.json");
    const Groundwork ground = lay_groundwork(study);
    const TermPlan plan = plan_terms(study, ground, study.terms);
    return message(scene_warnings(study, ground, plan.terms, plan.captured), "truncated-terms");
  };
  EXPECT_TRUE(has(said(R"(, "terms": {"zernike": {"n_max": 3}})"), "raise n_max"));
  const std::string spherical = said(R"(, "terms": {"spherical": ["c4"]})");
  EXPECT_TRUE(has(spherical, "leave `terms` out")) << spherical;
  EXPECT_FALSE(has(spherical, "n_max"));
  const CheckReport automatic = run_check(parse_study(study_of(rough), "study.json"), {});
  EXPECT_EQ(message(automatic.warnings, "truncated-terms"), "");
}

TEST(SceneWarnings, OfTargetsAreThoseOfCheck) {
  const std::string sharp = R"(, "target": {"statistics": {"ee50": {"value": "1 nm"}}})" + kSmooth;
  EXPECT_TRUE(
      has(message(run_check(parse_study(study_of(sharp), "study.json"), {}).warnings, "below-diffraction"),
          "ee50"));
}

TEST(SceneWarnings, GrazingIncidenceBelowThirtyNanometres) {
  const auto said = [](const std::string& wavelength) {
    const Study study = parse_study(study_of(kSmooth, wavelength), "study.json");
    const RadialPsd psd(*study.psd);
    const PhysicsChoice use = choose_physics(study, requested_physics(study), &psd);
    EXPECT_TRUE(use.theory_error && use.theory_error->applies);
    return message(use.warnings, "grazing-incidence");
  };
  EXPECT_TRUE(has(said("29.9 nm"), "grazing incidence")) << said("29.9 nm");
  EXPECT_EQ(said("30.1 nm"), "");
}

// Frequencies of 2e5 to 3e5 /m scatter once to 7.3 to 10.9 degrees: (3^2 - 2.744^2)/(3^2 - 2^2) = 0.294 of
// that energy lies beyond ten degrees. At 15 nm 8.5 % scatters, at 100 nm 98 %.
TEST(SceneWarnings, LightBeyondTenDegreesIsToldWhileItIsLittle) {
  const auto said = [](const std::string& rms) {
    const Study study = parse_study(study_of(R"(, "roughness": {"psd": {"model": "uniform", "rms": ")" + rms +
                                             R"(", "f_min": "2e5 /m", "f_max": "3e5 /m"}})"),
                                    "study.json");
    const RadialPsd psd(*study.psd);
    return choose_physics(study, requested_physics(study), &psd);
  };
  EXPECT_EQ(message(said("1 nm").warnings, "wide-angle-scatter"), "");
  const PhysicsChoice some = said("15 nm");
  EXPECT_TRUE(has(message(some.warnings, "wide-angle-scatter"), "% of the energy beyond 10 degrees"));
  EXPECT_EQ(some.theory, Theory::kGhs);
  EXPECT_TRUE(some.light_decides);
  const PhysicsChoice most = said("100 nm");
  EXPECT_EQ(message(most.warnings, "wide-angle-scatter"), "");
  EXPECT_TRUE(has(message(most.warnings, "theory-fallback"), "% of the energy beyond 10 degrees"));
  EXPECT_FALSE(most.light_decides);
}

// A uniform PSD from 2.5 to 5 cycles/m has an RMS slope per axis of 2 pi sqrt((2.5^2 + 5^2)/4) = 17.56 /m
// times its height; 4.6 slope^2 is a third of a margin of 1 % at 1.533 mm.
TEST(SceneWarnings, SteepSlopesWhereTheMarginSeesTheSecondOrder) {
  const auto said = [](const std::string& rms, const std::string& target) {
    const Study study = parse_study(
        study_of(R"(, "roughness": {"psd": {"model": "uniform", "rms": ")" + rms +
                 R"(", "f_min": "2.5 /m", "f_max": "5 /m"}}, "equivalence": {"margin": "1 %"}, "target": )" +
                 target),
        "study.json");
    return message(lay_groundwork(study).use.warnings, "steep-slopes");
  };
  // Only the focus is used, because such spots leave no planes beside it.
  const std::string geometric = R"({"theory": "geometric", "statistics": {"ee50": {}}})";
  EXPECT_TRUE(has(said("1.56 mm", geometric), "first order")) << said("1.56 mm", geometric);
  EXPECT_EQ(said("1.50 mm", geometric), "");
  EXPECT_EQ(said("1.56 mm", R"({"theory": "rays", "statistics": {"ee50": {}}})"), "");
}

// For the same slopes, 4.6 slope^2 equals the tolerance of a fit, 1e-3, at a slope of 0.01474. No mirror has
// the closed form's height, radii and angles at once.
TEST(SceneWarnings, TargetsOfSteepSlopesAreThoseOfRaysUnlessTheStudyNamesATheory) {
  const auto ground = [](double slope, const std::string& target, const std::string& trace = "") {
    const Study study = parse_study(
        study_of(fmt::format(R"(, "roughness": {{"psd": {{"model": "uniform", "rms": {}, "f_min": "200 /m",
                                  "f_max": "400 /m"}}}}{}{})",
                             slope / (2 * std::numbers::pi * std::sqrt((200. * 200 + 400 * 400) / 4)), target,
                             trace),
                 "100 nm"),
        "study.json");
    return lay_groundwork(study);
  };
  const auto of = [&](double slope, const std::string& target, const std::string& trace = "") {
    return ground(slope, target, trace).use;
  };
  const auto light = [&](double slope) { return specified_light(ground(slope, "")).values; };
  const PhysicsChoice below = of(0.0146, ""), above = of(0.0149, "");
  EXPECT_EQ(below.theory, Theory::kGhs);
  ASSERT_EQ(below.model, FocusModel::kRays) << below.reason;
  EXPECT_FALSE(has(below.reason, "random slopes"));
  EXPECT_EQ(above.theory, Theory::kRays);
  EXPECT_TRUE(above.light_decides) << "the verdict stays that of light";
  EXPECT_TRUE(has(above.reason, "0.1 % too small")) << above.reason;
  EXPECT_FALSE(light(0.0149).empty()) << "what light does of the specification is still said";
  EXPECT_EQ(light(0.0149).size(), light(0.0146).size());
  EXPECT_EQ(of(0.0149, R"(, "target": {"theory": "geometric"})").theory, Theory::kGeometric);
  EXPECT_EQ(of(0.0149, R"(, "target": {"theory": "ghs"})").theory, Theory::kGhs);
  EXPECT_EQ(of(0.0149, "", R"(, "trace": {"model": "waves"})").theory, Theory::kGhs);
  // The closest tolerance of a theory value decides; given values do not count.
  const std::string ee50 = R"(, "target": {"statistics": {"ee50": {)";
  EXPECT_EQ(of(0.0149, ee50 + R"("tolerance": 2e-3}}})").theory, Theory::kGhs);
  EXPECT_EQ(of(0.0146, ee50 + R"("tolerance": 9e-4}, "ee90": {}}})").theory, Theory::kRays);
  EXPECT_EQ(of(0.0149, ee50 + R"("value": "60 mm"}}})").theory, Theory::kGhs);
  // No wave theory exists for statistics about the centroid.
  const std::string centroid = R"(, "trace": {"centre": "centroid"})";
  EXPECT_EQ(of(0.0146, "", centroid).theory, Theory::kGeometric);
  EXPECT_EQ(of(0.0149, "", centroid).theory, Theory::kRays);
  EXPECT_EQ(of(0.0149, R"(, "target": {"convention": "paper"})").theory, Theory::kGeometric);
}

// Rays are forced upon a scene that needs waves. The targets stay, because the second order of the slope does
// not affect radii by wave optics.
TEST(SceneWarnings, TargetsStayThoseOfLightWhereRaysWillNotDo) {
  const Study study = parse_study(
      study_of(
          R"(, "roughness": {"psd": {"model": "uniform", "rms": "40 nm", "f_min": "1e5 /m", "f_max": "2e5 /m"}},
                   "trace": {"model": "rays"})"),
      "study.json");
  const Groundwork ground = lay_groundwork(study);
  ASSERT_GT(ground.numbers.rms_slope_per_axis, 0.02);
  EXPECT_EQ(ground.use.model, FocusModel::kRays);
  EXPECT_EQ(ground.use.theory, Theory::kGhs);
}

// Defocus sqrt(3) c (2 rho^2 - 1) on a parabola: the slope r / (2 f) + 4 sqrt(3) c r / R^2 turns rays away
// from the focus from 45 degrees on.
TEST(TraceWarnings, LostRaysAreThoseSteeperThanFortyFiveDegrees) {
  const Study study = parse_study(
      study_of(kValue + R"(, "terms": {"zernike": {"n_max": 2}}, "trace": {"rays": 2048})"), "study.json");
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = {{2, 0}};
  const auto traced = [&](double steepest) {
    const double c = (1 / steepest - 1 / (2 * kFocal)) * kRadius * kRadius / (4 * std::sqrt(3.0));
    return trace_surface(study, GivenSurface{terms, Eigen::VectorXd::Constant(1, c)}, 1);
  };
  const TraceReport lost = traced(0.9 * kRadius);
  const PupilSample pupil = make_pupil(study.aperture, study.trace.pupil);
  EXPECT_EQ(lost.rays, pupil.size());
  EXPECT_EQ(lost.lost_rays, ((pupil.x.square() + pupil.y.square()).sqrt() > 0.9 * kRadius).count());
  EXPECT_GT(lost.lost_rays, 0);
  const std::string said = message(lost.warnings, "lost-rays");
  EXPECT_TRUE(has(said, std::to_string(lost.lost_rays) + " of " + std::to_string(lost.rays))) << said;
  EXPECT_TRUE(has(said, "miss the focal region")) << said;
  const TraceReport whole = traced(1.1 * kRadius);
  EXPECT_EQ(whole.lost_rays, 0);
  EXPECT_EQ(message(whole.warnings, "lost-rays"), "");
}

// A mode of n = 2 has no third derivative, so central differences are exact but for rounding. For Z_3^3 =
// sqrt(8) rho^3 cos 3a they miss sqrt(8) c d^2/R^3 of dh/dx and nothing of dh/dy (x^3 - 3 x y^2). The RMS of
// the gradient is sqrt(8) c 3 / (R sqrt(3)), so the relative error is d^2/(R^2 sqrt(3)).
TEST(TraceWarnings, CentralDifferencesSayWhatTheyMissOfTheSlopes) {
  const auto said = [](const std::string& normals) {
    const Study study = parse_study(
        study_of(kValue + R"(, "terms": {"zernike": {"n_max": 3}}, "trace": {"rays": 2048)" + normals + "}"),
        "study.json");
    TermSet terms;
    terms.radius = kRadius;
    terms.zernike = {{3, 3}};
    return message(trace_surface(study, GivenSurface{terms, Eigen::VectorXd::Constant(1, 1e-7)}, 1).warnings,
                   "central-difference");
  };
  const double share = 0.05 * 0.05 / (kRadius * kRadius) / std::sqrt(3.0);
  const std::string coarse = said(R"(, "normals": {"central_difference": {"step": "50 mm"}})");
  EXPECT_TRUE(has(coarse, format_percent(share) + " of the RMS slope")) << coarse << ", by theory " << share;
  EXPECT_EQ(said(R"(, "normals": "analytic")"), "");
}

VerifyReport verified(const std::string& trace) {
  const Study study = parse_study(
      study_of(kSmooth + R"(, "terms": {"zernike": {"n_max": 4}}, "trace": {"rays": 512)" + trace + "}"),
      "study.json");
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(2, 4);
  const Eigen::VectorXd coefficients = 1e-9 * draw_white(terms.size(), 1);
  return verify(study, {}, GivenSurface{terms, coefficients}, {1});
}

TEST(VerifyWarnings, CentralDifferenceIsALowPassFilter) {
  const auto said = [](const std::string& normals) {
    return message(verified(R"(, "centre": "centroid")" + normals).warnings, "central-difference");
  };
  EXPECT_TRUE(has(said(R"(, "normals": {"central_difference": {"step": "1 mm"}})"), "low-pass filter"));
  EXPECT_EQ(said(R"(, "normals": "analytic")"), "");
}

TEST(VerifyWarnings, NoLightSaysWhatIsInTheWay) {
  const VerifyReport dark = verified(R"(, "centre": "centroid")"), lit = verified("");
  EXPECT_TRUE(has(message(dark.warnings, "no-light"), "the centroid")) << dark.light_obstacle;
  EXPECT_TRUE(dark.light.empty());
  EXPECT_EQ(message(lit.warnings, "no-light"), "");
  EXPECT_FALSE(lit.light.empty());
}

}  // namespace
}  // namespace aberfit
