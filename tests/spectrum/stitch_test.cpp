#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/random.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "psd_slope.h"

using namespace aberfit;

namespace {

PsdEstimate white(int n, double pitch, double level, const char* name) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(n, 0, pitch * (n - 1));
  profile.value.resize(n);
  const RandomStream stream(1, name);
  for (int i = 0; i < n; ++i)
    profile.value[i] = std::sqrt(0.5 * level / pitch) * stream.normal(std::uint64_t(i));
  PsdEstimatorOptions options;
  options.find_lines = false;
  return estimate_psd(profile, options);
}

bool disagrees(const PsdEstimate& estimate) {
  return std::any_of(estimate.warnings.begin(), estimate.warnings.end(),
                     [](const Warning& w) { return w.code == "bands-disagree"; });
}

}  // namespace

TEST(Stitch, BinsKeepLevelResponseAndCovariance) {
  const PsdEstimate coarse = white(400, 1e-3, 1, "coarse"), fine = white(400, 1e-4, 1, "fine");
  const PsdEstimate both = stitch({coarse, fine});
  EXPECT_GT(both.psd.size(), coarse.psd.size());
  for (Eigen::Index b = 1; b < both.psd.size(); ++b) EXPECT_GT(both.frequency[b], both.frequency[b - 1]);
  for (Eigen::Index b = 1; b < both.node_frequency.size(); ++b)
    EXPECT_GE(both.node_frequency[b], both.node_frequency[b - 1]);
  EXPECT_DOUBLE_EQ(both.frequency[0], coarse.frequency[0]);
  EXPECT_DOUBLE_EQ(both.frequency.tail(1)[0], fine.frequency.tail(1)[0]);
  // A constant spectrum gives each bin the level of its own band.
  const Eigen::VectorXd level = both.response * Eigen::VectorXd::Ones(both.node_frequency.size());
  EXPECT_NEAR(level[0], coarse.response.row(0).sum(), 1e-12);
  EXPECT_NEAR(level.tail(1)[0], fine.response.row(fine.psd.size() - 1).sum(), 1e-12);
  EXPECT_DOUBLE_EQ(both.relative_covariance(0, 1), coarse.relative_covariance(0, 1));
  EXPECT_EQ(both.relative_covariance(0, both.psd.size() - 1), 0);
}

// Bins that an instrument has filtered are dropped and do not displace those of another instrument.
TEST(Stitch, BinsBeyondTheEndOfAnInstrumentAreLeftOut) {
  PsdEstimate coarse = white(4000, 1e-3, 1, "coarse");
  const PsdEstimate fine = white(400, 1e-4, 1, "fine");
  const auto lowest_of_fine = [&](const PsdEstimate& both) {
    double lowest = HUGE_VAL;
    for (const double f : both.frequency)
      if ((fine.frequency == f).any()) lowest = std::min(lowest, f);
    return lowest;
  };
  const double before = lowest_of_fine(stitch({coarse, fine}));
  coarse.trusted_to = 100;
  const PsdEstimate both = stitch({coarse, fine});
  EXPECT_GT(before, 300);
  EXPECT_LT(lowest_of_fine(both), 150);
  for (const double f : both.frequency) EXPECT_TRUE(f <= 100 || (fine.frequency == f).any()) << f;
}

TEST(Stitch, DisagreeingBandsAreSaid) {
  EXPECT_TRUE(disagrees(stitch({white(400, 1e-3, 1, "coarse"), white(400, 1e-4, 100, "fine")})));
}

TEST(Stitch, KindsAreNotMixed) {
  PsdEstimate profile = white(64, 1e-3, 1, "a"), map = profile;
  map.kind = PsdTableKind::k2dTwoSided;
  EXPECT_THROW(stitch({profile, map}), std::invalid_argument);
  EXPECT_THROW(stitch({}), std::invalid_argument);
}

TEST(PsdSlope, WhiteNoiseHasExponentZeroWithinItsUncertainty) {
  const PsdEstimate estimate = white(2000, 1e-3, 3, "slope");
  const test::PsdSlope slope = test::psd_slope(estimate, 5, 400);
  EXPECT_LT(std::abs(slope.exponent), 4 * slope.exponent_std);
  EXPECT_LT(slope.exponent_std, 0.1);
  EXPECT_THROW(test::psd_slope(estimate, 1e5, 1e6), std::invalid_argument);
}
