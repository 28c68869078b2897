// Warnings of a finished fit: `conclude` on fits made by hand, on both sides of each rule, and one whole run
// that ends too soon on too few rays.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "aberfit/commands/run.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/conclude.h"
#include "aberfit/method/judge.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// 20 waves of phase: rays are accurate.
const char* const kSteep =
    R"(, "roughness": {"psd": {"model": "uniform", "rms": "2 um", "f_min": "2.5 /m", "f_max": "13 /m"}})";

// A 0.4 m f/7 mirror with 12 terms, by rays, because wave optics has no statistics about the centroid.
std::string scene(const std::string& rest) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "terms": {"zernike": {"n_max": 4}},
      "trace": {"centre": "centroid", "rays": 256})" +
         rest + "}";
}

// Given radii of a Gaussian spot of 20 um: `count` targets.
std::string with_values(int count) {
  std::string statistics;
  for (int k = 0; k < count; ++k) {
    const int percent = 10 + 7 * k;
    const double radius = 20 * std::sqrt(-2 * std::log(1 - percent / 100.0));
    statistics += fmt::format(R"({}"ee{}": {{"value": "{:.4f} um"}})", k == 0 ? "" : ", ", percent, radius);
  }
  return R"(, "target": {"statistics": {)" + statistics +
         R"(}}, "fit": {"prior": "zero-mean", "max_iterations": 1})";
}

// A good fit that a test then changes: no lost rays, 30 rays per term, a flat surface.
struct Fitted {
  Study study;
  Layout layout;
  std::shared_ptr<const TermPlan> terms;
  RunContext context{1};

  explicit Fitted(const std::string& text)
      : study(parse_study(text, "study.json")),
        layout(lay_out(study, 1)),
        terms(std::make_shared<const TermPlan>(plan_terms(study, layout.ground, study.terms))) {}

  template <typename Change>
  FitOutcome concluded(const Change& change) const {
    const FitCase of{study, layout.ground, layout.targets, context};
    const FitPlan plan = make_plan(study, terms);
    Attempt attempt;
    attempt.terms = terms;
    attempt.bench =
        std::make_shared<const Workbench>(study, FocusModel::kRays, plan.pupil, 0, terms->terms, 1);
    attempt.result = outcome_of(of, plan);
    attempt.result.fitted.fit.status = FitStatus::kConverged;
    attempt.result.fitted.fit.coefficients = Eigen::VectorXd::Zero(terms->terms.size());
    attempt.result.fitted.rays = 30 * terms->terms.size();
    attempt.fresh.rays = 4 * attempt.result.fitted.rays;
    change(&attempt);
    conclude(of, &attempt);
    return attempt.result;
  }
};

std::vector<std::string> messages(const FitOutcome& result, const std::string& code) {
  std::vector<std::string> found;
  for (const Warning& warning : result.warnings)
    if (warning.code == code) found.push_back(warning.message);
  return found;
}
bool says(const std::vector<std::string>& messages, const std::string& word) {
  return std::any_of(messages.begin(), messages.end(),
                     [&](const std::string& message) { return message.find(word) != std::string::npos; });
}

TEST(FitWarnings, FewRaysBelowThirtyATermWithMoreThanTenTargets) {
  const Fitted eleven(scene(with_values(11))), ten(scene(with_values(10)));
  ASSERT_EQ(eleven.terms->terms.size(), 12);
  const auto with_rays = [](Eigen::Index rays) {
    return [rays](Attempt* attempt) { attempt->result.fitted.rays = rays; };
  };
  const std::vector<std::string> found = messages(eleven.concluded(with_rays(359)), "few-rays");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found, "359 rays for 12 terms")) << found[0];
  EXPECT_TRUE(says(found, "use more rays")) << found[0];
  EXPECT_TRUE(messages(eleven.concluded(with_rays(360)), "few-rays").empty());
  EXPECT_TRUE(messages(ten.concluded(with_rays(359)), "few-rays").empty());
}

TEST(FitWarnings, FewRaysIsNoWordOfWaves) {
  Fitted waves(scene(with_values(11)));
  waves.layout.ground.use.model = FocusModel::kWaves;
  EXPECT_TRUE(
      messages(waves.concluded([](Attempt* attempt) { attempt->result.fitted.rays = 12; }), "few-rays")
          .empty());
}

TEST(FitWarnings, NotConvergedGivesTheSolversReason) {
  const Fitted fitted(scene(with_values(1)));
  const auto ended = [](FitStatus status) {
    return [status](Attempt* attempt) {
      attempt->result.fitted.fit.status = status;
      attempt->result.fitted.fit.message = "it ran out of patience";
    };
  };
  const std::vector<std::string> found =
      messages(fitted.concluded(ended(FitStatus::kNotConverged)), "not-converged");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found, "no verdict")) << found[0];
  EXPECT_TRUE(says(found, "it ran out of patience")) << found[0];
  EXPECT_TRUE(messages(fitted.concluded(ended(FitStatus::kConverged)), "not-converged").empty());
}

TEST(FitWarnings, LostRaysCountsFreshOnes) {
  const Fitted fitted(scene(with_values(1)));
  const auto with_lost = [](Eigen::Index lost) {
    return [lost](Attempt* attempt) { attempt->fresh.lost = lost; };
  };
  const std::vector<std::string> found = messages(fitted.concluded(with_lost(1)), "lost-rays");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found, "1 of 1440 fresh rays miss")) << found[0];
  EXPECT_TRUE(messages(fitted.concluded(with_lost(0)), "lost-rays").empty());
}

// Coefficients are RMS heights, so a single one is the height of the surface.
TEST(FitWarnings, AbsurdSurfaceAboveThreeTimesTheHeightItsTermsStandFor) {
  const Fitted fitted(scene(kSteep));
  const double specified = psd_moments(*fitted.layout.ground.term_psd).rms_height();
  const auto with_height = [&](double times) {
    return [=](Attempt* attempt) { attempt->result.fitted.fit.coefficients[2] = times * specified; };
  };
  const std::vector<std::string> found = messages(fitted.concluded(with_height(3.1)), "absurd-surface");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found, "3.1 times")) << found[0];
  EXPECT_TRUE(messages(fitted.concluded(with_height(2.9)), "absurd-surface").empty());
}

// The specification needs rays; a fiftieth of its heights, 0.8 rad of phase, needs waves.
TEST(FitWarnings, SurfaceRegimeWhereTheFittedSurfaceCallsForAnotherModel) {
  const Fitted fitted(scene(std::string(kSteep) + R"(, "equivalence": {"margin": "90 %"})"));
  ASSERT_EQ(regime(fitted.layout.ground.numbers), FocusModel::kRays);
  const Eigen::VectorXd draw =
      fitted.terms->prior.colour(draw_white(fitted.terms->terms.size(), fitted.study.fit.seed));
  const auto with_height = [&](double factor) {
    return fitted.concluded([&](Attempt* a) { a->result.fitted.fit.coefficients = factor * draw; });
  };
  const FitOutcome flat = with_height(0.02), like = with_height(1);
  const std::vector<std::string> found = messages(flat, "surface-regime");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found, "needs waves")) << found[0];
  EXPECT_TRUE(says(found, "needs rays")) << found[0];
  EXPECT_EQ(flat.fitted.surface.needed, "waves");
  EXPECT_TRUE(messages(like, "surface-regime").empty());
  EXPECT_EQ(like.fitted.surface.needed, "rays");
}

TEST(FitWarnings, ReachTheResultOfARun) {
  const ResultDocument result = run_fit(parse_study(scene(with_values(11)), "study.json"), {});
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kNotConverged) << result.fitted.fit.message;
  EXPECT_TRUE(says(messages(result, "not-converged"), result.fitted.fit.message));
  EXPECT_TRUE(says(messages(result, "few-rays"), "single rays"));
}

// The fit's own rays and the fresh ones both lack one width; only the fresh ones are reported.
TEST(FitWarnings, OfAStatisticAreSaidOnce) {
  const ResultDocument result =
      run_fit(parse_study(
                  R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
              "aperture": {"shape": "circle", "diameter": "0.4 m"}, "terms": {"zernike": {"n_max": 4}},
              "trace": {"centre": "centroid", "rays": 32}, "output": {"pictures": "none"},
              "target": {"statistics": {"ee50": {"value": "20 um"}, "ring_fwhm@ee5": {"value": "200 um"}}},
              "fit": {"prior": "zero-mean"}})",
                  "study.json"),
              {});
  EXPECT_EQ(messages(result, "ring-fwhm-crossings").size(), 1u);
}

// The planes of a rough mirror are thousands of wavelengths of defocus for a perfect one, where it cannot be
// computed in reasonable time. The focus alone distinguishes the two.
TEST(PerfectMirror, IsAskedBesideTheFocusOnlyWhereTheFocusDoesNotTell) {
  const auto asked = [](const char* rms) {
    const Fitted fitted(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "0.173 m"}}, "aperture":
        {{"shape": "annulus", "diameter": "0.1076 m", "inner_diameter": "0.0589 m"}}, "light": {{"wavelength":
        "762.6 nm"}}, "roughness": {{"psd": {{"model": "k-correlation", "rms": "{}", "B": "2.7 mm",
        "exponent": 3.75, "f_min": "18.3 /m", "f_max": "1372 /m"}}}}, "terms": {{"zernike": {{"n_max": 8}}}}}})",
                                    rms));
    return judge_perfect_mirror({fitted.study, fitted.layout.ground, fitted.layout.targets, fitted.context});
  };
  const std::optional<PerfectMirror> rough = asked("1.27 um"), smooth = asked("0.3 nm");
  ASSERT_TRUE(rough && smooth);
  EXPECT_GT(rough->mismatch, 10);
  EXPECT_EQ(rough->statistic.find('@'), std::string::npos) << rough->statistic;
  EXPECT_LT(smooth->mismatch, 1);
  EXPECT_NE(smooth->statistic.find('@'), std::string::npos) << smooth->statistic;
}

}  // namespace
}  // namespace aberfit
