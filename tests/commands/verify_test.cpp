#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/read_study.h"

using namespace aberfit;

namespace {

const std::string kStudy = ABERFIT_SOURCE_DIR "/fits/paper-verify/study.json";

// The shipped study with this number of realisations.
Study short_study(int draws) {
  Study study = read_study(kStudy);
  study.verify_draws = draws;
  return study;
}

}  // namespace

// The decision uses ensemble means. Terms that cannot carry the roughness are `different` by rays and by wave
// optics.
TEST(Verify, TermsThatCannotCarryTheRoughnessAreDifferent) {
  Study study = short_study(64);
  study.terms.zernike->n_max = 12;  // 13/(2 pi R) = 10 of 40 cycles/m
  const VerifyReport report = run_verify(study, {});
  EXPECT_EQ(report.verdict, Verdict::kDifferent);
  EXPECT_EQ(report.rays_verdict, Verdict::kDifferent);
  EXPECT_EQ(report.light_verdict, Verdict::kDifferent);
  EXPECT_EQ(report.draws, 64);
}

TEST(Verify, FewDrawsDecideNothingAndSaySo) {
  const VerifyReport report = run_verify(short_study(16), {});
  EXPECT_EQ(report.verdict, Verdict::kUndecided);
  bool warned = false;
  for (const Warning& warning : report.warnings) warned = warned || warning.code == "few-draws";
  EXPECT_TRUE(warned);
}

// Wave optics decides unless the study names rays.
TEST(Verify, LightDecidesUnlessTheStudyNamesRays) {
  Study study = short_study(64);
  study.target = {};
  study.psd = PsdModel(UniformPsd{25.18e-9, 2.5, 19.96});
  study.terms.zernike->n_max = 30;
  study.equivalence.margin = 0.05;
  const VerifyReport report = run_verify(study, {});
  EXPECT_FALSE(report.rays_decide);
  EXPECT_EQ(report.verdict, report.light_verdict);
  EXPECT_EQ(report.light_verdict, Verdict::kEquivalent);
  EXPECT_EQ(to_json(report, {})["decided_by"], "light");
  for (const EquivalenceMetric& m : report.light)
    EXPECT_NEAR(m.difference, 0, 4.5 * m.standard_error) << m.name;
}

TEST(Verify, TheSameBitsForAnyNumberOfThreads) {
  RunOptions one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(to_json(run_verify(short_study(16), one), {}).dump(),
            to_json(run_verify(short_study(16), two), {}).dump());
}
