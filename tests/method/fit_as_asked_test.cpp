// The terms of a fit: those of the law, more where these are too few, or the fewest that are enough.
#include "aberfit/method/fit_as_asked.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/constants.h"
#include "model_studies.h"

namespace aberfit {
namespace {

// The band of the terms ends at f_max, below any cut that wave optics would choose.
Study study_to(double f_max, const std::string& rest = "") {
  return parse_study(
      text_of(fmt::format(R"({{"model": "uniform", "rms": "25 nm", "f_min": "2.5 /m", "f_max": {}}})", f_max),
              "{}", "{}", R"({"shape": "circle", "diameter": "0.4 m"})", rest),
      "study.json");
}

TermsSpec law_of(const Study& study, double growth = 1) {
  const Layout layout = lay_out(study, 1);
  return terms_by_law(study, layout.ground, growth);
}

TEST(LawOfTerms, ZernikesReachATenthBeyondTheBand) {
  for (const double f_max : {5.0, 8.0, 12.0, 19.96}) {
    const TermsSpec terms = law_of(study_to(f_max, R"(, "terms": {"band": "all"})"));
    ASSERT_TRUE(terms.zernike) << f_max;
    EXPECT_EQ(terms.zernike->n_min, 1) << f_max;
    EXPECT_EQ(*terms.zernike->n_max, std::ceil(1.1 * 2 * std::numbers::pi * 0.2 * f_max)) << f_max;
  }
}

TEST(LawOfTerms, GrowsByTheOrder) {
  const Study study = study_to(19.96, R"(, "terms": {"band": "all"})");
  EXPECT_EQ(*law_of(study, 1.15).zernike->n_max, std::ceil(1.15 * *law_of(study).zernike->n_max));
}

// 2 pi 0.2 m 80 /m = 100.5 is beyond the last order; 800 /m are 320 cycles across, 161,000 waves.
TEST(LawOfTerms, TakesTheWholeFrequencyGridWhereOrdersEndAndRingsWhereThatIsTooMuch) {
  const auto sampling = [](double f_max) {
    const TermsSpec terms = law_of(study_to(f_max, R"(, "terms": {"band": "all"})"));
    EXPECT_FALSE(terms.zernike) << f_max;
    return terms.fourier.value().sampling;
  };
  EXPECT_EQ(sampling(80), FourierSampling::kGrid);
  EXPECT_EQ(sampling(800), FourierSampling::kLog);
}

TEST(LawOfTerms, ResolvesToAStudyThatGivesTheSameFit) {
  const Study study = study_to(8, R"(, "output": {"pictures": "none"})");
  const ResultDocument found = run_fit(study, {});
  EXPECT_EQ(found.judgement.verdict, Verdict::kEquivalent);
  ASSERT_TRUE(found.choices.frontier);
  EXPECT_EQ(found.choices.frontier->points.size(), 1u);
  EXPECT_FALSE(found.choices.frontier->fewest);
  const ResultDocument again =
      run_fit(parse_study(resolved_study(study, found.choices.values).dump(), "study.json"), {});
  EXPECT_EQ(again.fitted.fit.coefficients, found.fitted.fit.coefficients);
}

TEST(Fewest, AreEquivalentAndNoMoreThanTheLawsAndATenthLowerIsNot) {
  Study study = study_to(19.96, R"(, "terms": "fewest", "output": {"pictures": "none"})");
  const ResultDocument found = run_fit(study, {});
  ASSERT_EQ(found.judgement.verdict, Verdict::kEquivalent);
  ASSERT_TRUE(found.choices.frontier);
  EXPECT_TRUE(found.choices.frontier->fewest);
  int passed = 0, failed = 0;  // lowest order that passes, highest that fails
  for (const FrontierPoint& point : found.choices.frontier->points) {
    if (point.passes && (passed == 0 || point.order < passed)) passed = point.order;
    if (!point.passes) failed = std::max(failed, point.order);
    if (point.chosen) {
      EXPECT_EQ(point.order, found.fitted.terms.zernike.back().n);
    }
  }
  EXPECT_EQ(found.fitted.terms.zernike.back().n, passed);
  EXPECT_LT(passed, *law_of(study_to(19.96)).zernike->n_max);
  EXPECT_LE(passed, std::ceil(law::kFewestWithin * failed));
  EXPECT_NE(found.choices.frontier->message.find("held-out statistics selected it"), std::string::npos);
}

// Random starts are tried in turn. A study with the number tried gives the same fit.
TEST(Starts, GoOnUntilOneIsEquivalent) {
  const auto fitted = [](int starts) {
    Study study = study_to(19.96, R"(, "terms": {"zernike": {"n_max": 9}, "band": "auto"},
        "fit": {"max_iterations": 12}, "output": {"pictures": "none"})");
    study.fit.starts = starts;
    return run_fit(study, {});
  };
  const ResultDocument one = fitted(1), three = fitted(3);
  ASSERT_NE(one.judgement.verdict, Verdict::kEquivalent) << "nothing tested";
  EXPECT_EQ(one.choices.values.starts, 1);
  EXPECT_GT(three.choices.values.starts, 1);
}

}  // namespace
}  // namespace aberfit
