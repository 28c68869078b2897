// What a search makes for each of its trials.
#include "aberfit/method/fewest_terms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "aberfit/method/ray_count.h"
#include "aberfit/method/term_search.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

const char* const kStudy = R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"},
    "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"},
    "roughness": {"psd": {"model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "12 /m"}},
    "target": {"theory": "geometric"}, "equivalence": {"margin": "2 %"}, "terms": "auto"})";

TEST(FewestTerms, MakesTermsAndPriorOnceForEachTrial) {
  const Study study = parse_study(kStudy, "study.json");
  const Groundwork ground = lay_groundwork(study);
  const TargetSets targets = make_targets(study, ground, 1);
  // The search tells what it does: a prior, then the fit or fits that stand on it.
  std::vector<std::string> told;
  const RunContext context{1,
                           [&](const std::string& line) { told.push_back(line.substr(0, line.find(':'))); }};
  std::vector<int> made;
  const MakeTerms counted = [&](const TermsSpec& asked) {
    made.push_back(asked.zernike.value().n_max.value());
    return plan_terms(study, ground, asked);
  };
  const Attempt found = fit_fewest_terms({study, ground, targets, context}, counted);
  ASSERT_TRUE(found.result.frontier.has_value());
  ASSERT_GT(made.size(), 2u);
  EXPECT_EQ(std::adjacent_find(made.begin(), made.end()), made.end()) << "the same terms made twice in a row";
  // An order is looked at while climbing and once more on the way down, never a third time.
  std::map<int, int> times;
  for (const int order : made) ++times[order];
  for (const auto& [order, count] : times) EXPECT_LE(count, 2) << "n <= " << order;
  EXPECT_EQ(std::size_t(std::count(told.begin(), told.end(), "prior")), made.size());
  // Every set of the frontier was made, and what was found stands on the terms of its trial.
  for (const FrontierPoint& point : found.result.frontier->points) EXPECT_TRUE(times.contains(point.order));
  EXPECT_EQ(found.result.terms.zernike, found.terms->terms.zernike);
  EXPECT_EQ(found.result.fit.coefficients.size(), found.terms->prior.size());
}

// By rays 1.3 tolerances or margins unless there are the most, by waves 1.6, on many cells 1.1; and from
// nowhere there is no way on.
TEST(SecondLook, IsForWhatMissesByLittle) {
  const Study study = parse_study(kStudy, "study.json");
  TermSet none;
  none.radius = 0.2;
  const auto deserves = [&](FocusModel model, Eigen::Index cells, double mismatch, FitStatus status) {
    Attempt attempt;
    attempt.bench = std::make_shared<const Workbench>(study, model, PupilOptions{PupilLayout::kPolar, 64, 1},
                                                      0.4 / 16, none, 1);
    attempt.result.rays = attempt.result.chosen.rays = cells;
    attempt.result.fit.status = status;
    attempt.mismatch = mismatch;
    return deserves_second_look(attempt);
  };
  const FitStatus missed = FitStatus::kNotConverged;
  EXPECT_TRUE(deserves(FocusModel::kRays, 65536, 1.25, missed));
  EXPECT_FALSE(deserves(FocusModel::kRays, 65536, 1.35, missed));
  EXPECT_TRUE(deserves(FocusModel::kRays, kMostAutomaticRays / 2, 1.05, missed));
  EXPECT_FALSE(deserves(FocusModel::kRays, kMostAutomaticRays, 1.05, missed));
  EXPECT_TRUE(deserves(FocusModel::kWaves, kManyCells + kMostAutomaticRays, 1.05, missed));
  EXPECT_TRUE(deserves(FocusModel::kWaves, 5000, 1.55, missed));
  EXPECT_TRUE(deserves(FocusModel::kWaves, 5000, 1.55, FitStatus::kCancelled));
  EXPECT_FALSE(deserves(FocusModel::kWaves, 5000, 1.65, missed));
  EXPECT_TRUE(deserves(FocusModel::kWaves, kManyCells, 1.05, missed));
  EXPECT_FALSE(deserves(FocusModel::kWaves, kManyCells, 1.15, missed));
  EXPECT_FALSE(deserves(FocusModel::kWaves, 5000, 1.05, FitStatus::kFailed));
}

}  // namespace
}  // namespace aberfit
