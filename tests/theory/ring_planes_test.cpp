// The search for a ring's peak and half crossings, on curves with closed forms.
#include "../../src/theory/ring_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using aberfit::GeneralisedHarveyShack;
using aberfit::internal::ring_halves;

namespace {

constexpr double kAccuracy = 1e-9;

// In any unit, and for small first steps.
TEST(RingPlanes, FollowAPeakWhereverItLies) {
  for (const double width : {0.02, 2e-7, 2e6})
    for (const double off : {0.0, 1e-6, -1e-3, 0.07, -0.31, 2.3, -6.0})
      for (const double steps : {2.83, 5.0, 17.0, 300.0, 6000.0}) {
        int looks = 0;
        const auto gaussian = [&](double z) {
          ++looks;
          return 0.7 * std::exp2(-4 * std::pow(z / width - off, 2));
        };
        if (std::abs(off) * steps > 60) continue;  // far outside the first steps
        const GeneralisedHarveyShack::RingPlanes found =
            ring_halves(gaussian, {width / steps, 50 * width, kAccuracy, kAccuracy});
        EXPECT_NEAR(found.peak / width, off, 3e-5) << steps;
        EXPECT_NEAR(found.lower / width, off - 0.5, 2e-9) << steps;
        EXPECT_NEAR(found.upper / width, off + 0.5, 2e-9) << steps;
        EXPECT_LT(looks, (steps < 100    ? 45
                          : steps < 1000 ? 125
                                         : 260) +
                             2 * std::abs(off) * steps)
            << off << " " << steps;
      }
}

// exp(a z^2 - z^4): a dip of a^2/4 between peaks at +-sqrt(a/2), half crossings at sqrt(a/2 + sqrt(ln 2)).
TEST(RingPlanes, SeeThatTheFocusLiesBetweenTwoPeaks) {
  for (const double a : {1e-4, 0.05, 0.2, 0.4, 0.8, 1.5})
    for (const double steps : {2.83, 4.0, 5.0, 17.0, 300.0}) {
      const double half = std::sqrt(a / 2 + std::sqrt(std::numbers::ln2));
      int looks = 0;
      const auto two = [&](double z) {
        ++looks;
        return 0.9 * std::exp(a * z * z - std::pow(z, 4));
      };
      const GeneralisedHarveyShack::RingPlanes found =
          ring_halves(two, {2 * half / steps, 100.0, kAccuracy, kAccuracy});
      EXPECT_NEAR((found.upper - found.lower) / (2 * half), 1, 2e-9) << a << " " << steps;
      EXPECT_LT(looks, steps < 100 ? 50 : 125) << a << " " << steps;
    }
}

// The higher of two unequal peaks: exp(a z^2 - z^4) (1 + t z).
TEST(RingPlanes, TakeTheHigherPeak) {
  for (const double tilt : {-0.02, 0.02}) {
    const auto two = [&](double z) { return std::exp(0.8 * z * z - std::pow(z, 4)) * (1 + tilt * z); };
    const GeneralisedHarveyShack::RingPlanes found = ring_halves(two, {0.45, 100.0, kAccuracy, kAccuracy});
    EXPECT_GT(found.peak * tilt, 0);
    EXPECT_LT(two(found.peak + 1e-3), two(found.peak));
    EXPECT_LT(two(found.peak - 1e-3), two(found.peak));
    EXPECT_NEAR(two(found.upper) / two(found.peak), 0.5, 1e-8);
    EXPECT_NEAR(two(found.lower) / two(found.peak), 0.5, 1e-8);
  }
}

TEST(RingPlanes, AreNoneWhereHalfLiesTooFarAway) {
  const auto gaussian = [](double z) { return std::exp2(-4 * z * z); };
  for (const double step : {0.3, 0.143, 0.01}) {
    const GeneralisedHarveyShack::RingPlanes inside =
        ring_halves(gaussian, {step, 0.501, kAccuracy, kAccuracy});
    EXPECT_NEAR(inside.upper, 0.5, 1e-8) << step;
    EXPECT_NEAR(inside.lower, -0.5, 1e-8) << step;
    const GeneralisedHarveyShack::RingPlanes outside =
        ring_halves(gaussian, {step, 0.499, kAccuracy, kAccuracy});
    EXPECT_TRUE(std::isnan(outside.upper) && std::isnan(outside.lower)) << step;
  }
  // Half of the peak, not of the focus.
  const auto beside = [](double z) { return std::exp2(-4 * (z + 0.2) * (z + 0.2)); };
  EXPECT_NEAR(ring_halves(beside, {0.2, 0.71, kAccuracy, kAccuracy}).lower, -0.7, 1e-8);
}

}  // namespace
