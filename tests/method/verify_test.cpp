// How verify decides: how many draws, and differences in shares of the light.
#include "aberfit/method/verify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/method/constants.h"

namespace aberfit {
namespace {

TEST(EnsembleDraws, MakeTheMeanAsSureAsTheMarginNeeds) {
  // 4.62 standard errors 1.5 spread/sqrt(draws) in the margin, in whole groups.
  for (const double spread : {1.0, 1.5, 2.5, 3.0}) {
    const int draws = ensemble_draws(spread);
    EXPECT_EQ(draws % law::kGroups, 0);
    EXPECT_LE(1.5 * 4.62 * spread / std::sqrt(double(draws)), 1 + 1e-12);
    EXPECT_GT(1.5 * 4.62 * spread / std::sqrt(double(draws - law::kGroups)), 1 - 1e-12);
  }
  EXPECT_EQ(ensemble_draws(1e-6), 2 * law::kGroups);
  EXPECT_EQ(ensemble_draws(50), law::kMostGroupDraws * law::kGroups);
  EXPECT_EQ(ensemble_draws(NAN), law::kMostGroupDraws * law::kGroups);
}

TEST(ShareMetric, IsTheRadiusWhereTheCurveIsSteep) {
  // A Gaussian spot of sigma 1 um whose truth is 0.4 % wider: E(r) = 1 - exp(-r^2/2 s^2).
  const double sigma = 1e-6, wider = 1.004, p = 0.5;
  const double r = sigma * std::sqrt(-2 * std::log(1 - p)), slope = r / (sigma * sigma) * (1 - p);
  const double share = 1 - std::exp(-0.5 * r * r / (wider * wider * sigma * sigma));
  ASSERT_GT(r * slope, 0.35);
  const EquivalenceMetric m = share_metric("ee50", p, r, slope, share, 1e-6, 0.01, 0.95);
  EXPECT_NEAR(m.relative_difference, wider - 1, 2e-5);  // to first order: the square is 1.6e-5
  EXPECT_NEAR(m.model / r, wider, 2e-5);
  EXPECT_EQ(m.target, r);
  EXPECT_EQ(m.verdict, Verdict::kEquivalent);
  EXPECT_EQ(share_metric("ee50", p, r, slope, p - 0.02, 1e-6, 0.01, 0.95).verdict, Verdict::kDifferent);
  EXPECT_EQ(share_metric("ee50", p, r, slope, p - 0.004, 0.01, 0.01, 0.95).verdict, Verdict::kUndecided);
}

TEST(ShareMetric, IsTheLightWhereTheCurveIsFlat) {
  // Between core and halo: 0.2 % of the light is 20 % of the radius, and nothing to speak of.
  const double r = 1e-5, slope = 0.01 / r;
  const EquivalenceMetric m = share_metric("ee80", 0.8, r, slope, 0.798, 1e-4, 0.01, 0.95);
  EXPECT_NEAR(m.relative_difference, 0.002 / 0.35, 1e-12);
  EXPECT_NEAR(m.model / r, 1.2, 1e-12);
  EXPECT_EQ(m.verdict, Verdict::kEquivalent);
  const EquivalenceMetric far = share_metric("ee80", 0.8, r, slope, 0.79, 1e-4, 0.01, 0.95);
  EXPECT_EQ(far.verdict, Verdict::kDifferent);
  EXPECT_TRUE(std::isnan(far.model)) << "the slope here says nothing of a radius twice as large";
}

}  // namespace
}  // namespace aberfit
