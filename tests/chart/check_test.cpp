// The cost of a fit by `check` against the fit: its first terms, its points, and one measured iteration.
#include "aberfit/chart/check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/memory.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

Study study_of(const std::string& more,
               const std::string& psd = R"("model": "uniform", "rms": "25 nm", "f_min": 5, "f_max": 20)") {
  return parse_study(R"({"aberfit": 1, "mirror": {"focal_length": 2.8},
      "aperture": {"shape": "circle", "diameter": 0.2}, "light": {"wavelength": "632.8 nm"},
      "roughness": {"psd": {)" +
                         psd + "}}" + more + "}",
                     "study.json");
}

CheckReport measured(const Study& study) {
  RunOptions options;
  options.threads = 1;
  options.measure_iteration = true;
  return run_check(study, options);
}

TEST(CheckedCost, IsOfTheFitThatFollows) {
  for (const char* model : {"rays", "waves"}) {
    SCOPED_TRACE(model);
    const Study study = study_of(R"(, "terms": {"zernike": {"n_max": 12}, "band": "all"},
        "trace": {"rays": 20000, "model": ")" +
                                 std::string(model) + R"("}, "fit": {"max_iterations": 1})");
    const CheckReport report = measured(study);
    ASSERT_TRUE(report.cost);
    EXPECT_EQ(report.cost->obstacle, "");
    ASSERT_TRUE(report.cost->iteration_seconds);
    EXPECT_GT(*report.cost->iteration_seconds, 0);
    EXPECT_GT(report.cost->verdict_seconds.value_or(0), 0);
    EXPECT_FALSE(report.cost->at_least);
    EXPECT_EQ(report.cost->residuals, Eigen::Index(report.statistics.fitted + report.statistics.guides));
    EXPECT_EQ(report.terms.count, run_fit(study, {}).fitted.terms.size());
    EXPECT_FALSE(report.terms.automatic);
    // The present memory of the process is below its peak.
    EXPECT_GT(report.cost->bytes, 1e6);
    EXPECT_LE(report.cost->bytes, peak_memory());
  }
}

// The order is 1.1 times 2 pi R f_c, written anew, with the reported cut.
TEST(CheckedCost, AutomaticTermsCarryTheBandUpToTheCut) {
  const Study study = study_of("", R"("model": "k-correlation", "rms": "25 nm", "B": "60 mm", "exponent": 3,
      "f_min": "6 /m", "f_max": "2000 /m")");
  const CheckReport report = run_check(study, {});
  ASSERT_TRUE(report.shares);
  EXPECT_TRUE(report.terms.automatic);
  EXPECT_EQ(report.terms.order, int(std::ceil(1.1 * 2 * std::numbers::pi * 0.1 * report.shares->cut)));
  EXPECT_FALSE(report.cost);  // not requested
}

TEST(CheckedCost, WhatNeedsNoTermHasNoIteration) {
  const Study study = study_of("", R"("model": "uniform", "rms": "0.5 nm", "f_min": 2000, "f_max": 9000)");
  const CheckReport report = measured(study);
  ASSERT_TRUE(report.cost);
  EXPECT_FALSE(report.cost->iteration_seconds);
  EXPECT_NE(report.cost->obstacle.find("no frequency needs a term"), std::string::npos)
      << report.cost->obstacle;
}

}  // namespace
}  // namespace aberfit
