// Where fits by waves begin on many cells: near their targets already, where fits by rays have led.
#include "../../src/method/ray_approach.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "aberfit/core/random.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/prior_draws.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/term_search.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

Study study_of(const std::string& rms, const std::string& more = "", int n_max = 22) {
  return parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "2.8 m"}},
        "aperture": {{"shape": "circle", "diameter": "0.4 m"}}, "light": {{"wavelength": "632.8 nm"}},
        "roughness": {{"psd": {{"model": "uniform", "rms": "{}", "f_min": "2.5 /m", "f_max": "20 /m"}}}},
        "terms": {{"zernike": {{"n_max": {}}}, "band": "all"}}{}}})",
                                 rms, n_max, more),
                     "study.json");
}

double worst(const std::vector<Target>& targets, const Eigen::VectorXd& values) {
  double largest = 0;
  for (std::size_t k = 0; k < targets.size(); ++k)
    largest = std::max(largest, std::abs(values[Eigen::Index(k)] - targets[k].value) / targets[k].tolerance);
  return largest;
}

// A fit by waves on a grid that is small enough for a test.
struct Scene {
  explicit Scene(const Study& of, int threads = 2)
      : study(of),
        layout(lay_out(study, threads)),
        context{threads},
        fit_case{study, layout.ground, layout.targets, context} {}
  Study study;
  Layout layout;
  RunContext context;
  FitCase fit_case;
};

// What such a fit begins with.
struct Beginning {
  explicit Beginning(const FitCase& of)
      : fit_case(of),
        plan(make_plan(of.task,
                       std::make_shared<const TermPlan>(plan_terms(of.task, of.ground, of.task.terms)))),
        terms(plan.terms->terms),
        bench(of.task, FocusModel::kWaves, plan.pupil,
              wave_pitch(of.task, terms, all_targets(of.targets), of.ground.split.get(), kFirstCoarsening),
              terms, of.context.threads, of.ground.split),
        waves{bench.focus(of.task), plan.terms->prior, aims_of(of.targets.fitted), aims_of(of.targets.guides),
              of.ground.focal_sigma},
        draw(draw_white(plan.terms->prior.size(), 1)) {}

  std::optional<internal::RayStart> approached() const {
    return internal::approach_by_rays(fit_case, plan, 1, waves, draw);
  }
  // Of its targets, in tolerances.
  double mismatch(const Eigen::VectorXd& white) const {
    return worst(waves.targets, bench.exact(fit_case.task, waves.prior.colour(white),
                                            statistics_of(waves.targets), fit_case.context.threads, nullptr));
  }

  const FitCase& fit_case;
  FitPlan plan;
  const TermSet& terms;
  Workbench bench;
  FitProblem waves;
  Eigen::VectorXd draw;
};

TEST(RayApproach, IsForLightWithoutACoreOnVeryManyCells) {
  const auto begins = [](const Study& study, Eigen::Index cells, double wide) {
    const Scene scene(study);
    return begins_by_rays(study, scene.layout.ground, scene.layout.targets, cells, wide);
  };
  const Study deep = study_of("300 nm");
  EXPECT_TRUE(begins(deep, kVeryManyCells, 0.01));
  EXPECT_FALSE(begins(deep, kVeryManyCells - 1, 0.01));
  EXPECT_FALSE(begins(deep, kVeryManyCells, HUGE_VAL));  // a core
  EXPECT_FALSE(begins(study_of("300 nm", R"(, "fit": {"start": "zero"})"), kVeryManyCells, 0.01));
  EXPECT_FALSE(begins(study_of("300 nm", R"(, "target": {"theory": "geometric"})"), kVeryManyCells, 0.01));
  const auto asking = [](const char* statistics) {
    return study_of("300 nm", fmt::format(R"(, "target": {{"statistics": {{{}}}}})", statistics));
  };
  EXPECT_TRUE(begins(asking(R"("ee50": {}, "ee80": {})"), kVeryManyCells, 0.01));
  EXPECT_FALSE(
      begins(asking(R"("ee50": {}, "ensquared_within": {"sides": ["1 mm"]})"), kVeryManyCells, 0.01));
  EXPECT_FALSE(begins(asking(R"("ee50": {"value": "400 um"})"), kVeryManyCells, 0.01));
}

// What it says of its start is what light says of it; the draw is a hundred times as far off.
TEST(RayApproach, LeadsFromTheDrawToWithinAFewTolerances) {
  const Study study = study_of("300 nm");
  std::optional<Eigen::VectorXd> first;
  for (const int threads : {2, 1}) {
    const Scene scene(study, threads);
    ASSERT_EQ(scene.layout.ground.use.model, FocusModel::kWaves);
    const Beginning begin(scene.fit_case);
    const auto near = begin.approached();
    ASSERT_TRUE(near.has_value());
    const double before = begin.mismatch(begin.draw), after = begin.mismatch(near->white);
    RecordProperty("draw", fmt::format("{:.3g}", before));
    RecordProperty("start", fmt::format("{:.3g}", after));
    RecordProperty("fits", near->begun.fits);
    EXPECT_GT(before, 60);
    EXPECT_LT(near->begun.mismatch, 8);                   // 4.9; 14.8 by the theories alone
    EXPECT_LE(after, near->begun.mismatch * (1 + 1e-9));  // its guides count, too
    EXPECT_GE(near->begun.fits, 2);  // what rays and light differ by at the first surface is made use of
    if (first)
      EXPECT_EQ(near->white, *first);
    else
      first = near->white;
  }
}

// Stopped while its first fit has hardly begun it is no nearer than a draw, and says nothing; later it gives
// what that fit has come to.
TEST(RayApproach, KeepsWhatAStoppedFitHasComeToWhereItIsNearerThanADraw) {
  const Study study = study_of("300 nm");
  const auto stopped_after = [&](int questions) {
    Scene scene(study);
    scene.context.interrupted = [&questions] { return questions-- <= 0; };
    return Beginning(scene.fit_case).approached();
  };
  EXPECT_FALSE(stopped_after(0).has_value());  // not begun
  EXPECT_FALSE(stopped_after(2).has_value());  // a step
  const auto some = stopped_after(9);
  ASSERT_TRUE(some.has_value());
  EXPECT_EQ(some->begun.fits, 1);
  EXPECT_LT(some->begun.mismatch, 40);
  const Scene scene(study);
  EXPECT_LE(Beginning(scene.fit_case).mismatch(some->white), some->begun.mismatch * (1 + 1e-9));
}

// Terms that are too few for their statistics: the first fit ends far away, two more as far, and none are
// made after them. As far off as a draw it is no start.
TEST(RayApproach, EndsWhereTwoFitsHaveComeNoNearer) {
  Scene scene(study_of("300 nm", "", 10));
  int fits = 0;
  scene.context.progress = [&fits](const std::string& line) {
    fits += line.find("by rays: in light") != std::string::npos ? 1 : 0;
  };
  EXPECT_FALSE(Beginning(scene.fit_case).approached().has_value());
  EXPECT_EQ(fits, 3);
}

}  // namespace
}  // namespace aberfit
