// The band that slopes of zones are compared with holds 99 % of the draws of the prior.
#include <gtest/gtest.h>

#include "aberfit/method/plan.h"
#include "aberfit/method/prior_draws.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

TEST(ZoneSlopes, BandHolds99PercentOfTheDraws) {
  const Study study = parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
          "light": {"wavelength": "632.8 nm"},
          "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "6 /m"}},
          "terms": {"zernike": {"n_max": 6}}})",
      "study.json");
  const TermPlan plan = plan_terms(study, lay_groundwork(study), study.terms);
  constexpr int kDraws = 120;
  std::vector<int> outside(4, 0);
  for (int d = 0; d < kDraws; ++d) {
    const Eigen::VectorXd draw = plan.prior.colour(draw_white(plan.terms.size(), 5000 + std::uint64_t(d)));
    const std::vector<ZoneSlope> zones = zone_slopes(study, plan.terms, plan.prior, draw, 2);
    ASSERT_EQ(zones.size(), outside.size());
    for (std::size_t z = 0; z < zones.size(); ++z) outside[z] += !zones[z].inside();
    EXPECT_LT(zones[0].draws_low, zones[0].draws_high);
  }
  // Of 120 draws 1.2 lie outside; 7 or more by chance once in a thousand. Bands of 90 % leave out 12.
  int all = 0;
  for (const int count : outside) {
    EXPECT_LE(count, 6);
    all += count;
  }
  EXPECT_GE(all, 1);
}

}  // namespace
}  // namespace aberfit
