// Tests the warnings of the focal statistics with simple ray bundles on both sides of each rule.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/focus/evaluate.h"

namespace aberfit {
namespace {

constexpr double kRing = 1e-5, kSlope = 1e-3;  // a ray of that slope leaves the ring 1 cm from its focus
constexpr double kReach = kRing / kSlope;

// Rays in the plane y = 0 that cross the axis at dz = `focus`.
struct Beam {
  double weight, slope, focus;
};
RayBundle bundle(const std::vector<Beam>& beams) {
  RayBundle rays;
  const auto count = Eigen::Index(beams.size());
  for (Eigen::ArrayXd* part : {&rays.x, &rays.y, &rays.tx, &rays.ty, &rays.weight}) part->setZero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Beam& beam = beams[std::size_t(i)];
    rays.weight[i] = beam.weight;
    rays.tx[i] = beam.slope;
    rays.x[i] = -beam.slope * beam.focus;
  }
  return rays;
}

struct Seen {
  double value;
  Warnings warnings;
};
Seen seen(const RayBundle& rays, const Statistic& statistic) {
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(rays.size());
  Warnings warnings;
  const double value = evaluate_exact({rays, rays, flat}, {statistic}, 1, &warnings)[0];
  return {value, warnings};
}

TEST(FocusWarnings, NoLightWhereEveryRayIsLost) {
  const RayBundle dark = bundle({{0, kSlope, 0}, {0, -kSlope, 0}});
  const Seen none = seen(dark, EncircledEnergyRadius{0.5, 1e-3});
  EXPECT_TRUE(std::isnan(none.value));
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_EQ(none.warnings[0].code, "no-light");
  EXPECT_NE(none.warnings[0].message.find("every ray is lost"), std::string::npos);

  const Seen one = seen(bundle({{0, kSlope, 0}, {0.1, -kSlope, 0}}), EncircledEnergyRadius{0.5, 1e-3});
  EXPECT_TRUE(std::isfinite(one.value));
  EXPECT_TRUE(one.warnings.empty());
}

// Some of the energy stays inside the ring in every plane, like collimated rays. Below one half it only
// raises the profile. From one half on, the profile has no half maximum.
TEST(FocusWarnings, RingFwhmMissingWhereHalfTheLightNeverLeavesTheRing) {
  const auto with_steady = [](double share) {
    return bundle({{share, 0, 0}, {(1 - share) / 2, kSlope, 0}, {(1 - share) / 2, -kSlope, 0}});
  };
  const Seen none = seen(with_steady(0.51), RingFwhm{0.9, kRing});
  EXPECT_TRUE(std::isnan(none.value));
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_EQ(none.warnings[0].code, "ring-fwhm-missing");
  EXPECT_NE(none.warnings[0].message.find("half its maximum"), std::string::npos);
  EXPECT_EQ(none.warnings[0].message.find("ring_fwhm_m"), 0u) << none.warnings[0].message;

  const Seen found = seen(with_steady(0.49), RingFwhm{0.9, kRing});
  // The profile is 1 within the reach and 0.49 beyond. It is counted in 4096 planes over 16 ring / RMS slope.
  const double plane = 16 * kReach / std::sqrt(0.51) / 4096;
  EXPECT_NEAR(found.value, 2 * kReach, 2 * plane);
  EXPECT_TRUE(found.warnings.empty());
}

// Two foci are five reaches apart. The second adds crossings from half the energy of the first on.
TEST(FocusWarnings, RingFwhmCrossingsWhereASecondFocusIsHalfAsBright) {
  const auto with_second = [](double share) {
    return bundle({{1 - share, kSlope, 0}, {share, -kSlope, 5 * kReach}});
  };
  const double plane = 16 * kReach / 4096;
  for (const double share : {0.30, 0.37}) {  // 0.43 and 0.59 of the energy of the first focus
    const Seen found = seen(with_second(share), RingFwhm{0.9, kRing});
    EXPECT_NEAR(found.value, 2 * kReach, 2 * plane) << share;
    if (share < 1.0 / 3) {
      EXPECT_TRUE(found.warnings.empty());
      continue;
    }
    ASSERT_EQ(found.warnings.size(), 1u);
    EXPECT_EQ(found.warnings[0].code, "ring-fwhm-crossings");
    EXPECT_NE(found.warnings[0].message.find("4 times"), std::string::npos) << found.warnings[0].message;
  }
}

TEST(FocusWarnings, SpotFwhmMissingWhereTheBandwidthSeesSingleRays) {
  // The standard deviation is 1 um in x and in y.
  RayBundle rays = bundle({{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}});
  rays.x << 1e-6, -1e-6, 1e-6, -1e-6;
  rays.y << 1e-6, 1e-6, -1e-6, -1e-6;
  const Seen none = seen(rays, SpotFwhm{1e-6 / 20000});
  EXPECT_TRUE(std::isnan(none.value));
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_EQ(none.warnings[0].code, "spot-fwhm-missing");
  // The RMS radius is sqrt(2) um. The bandwidth that the message recommends must work.
  EXPECT_NE(none.warnings[0].message.find("1.414 um, so"), std::string::npos) << none.warnings[0].message;
  EXPECT_NE(none.warnings[0].message.find("707.1 pm is wide enough"), std::string::npos)
      << none.warnings[0].message;
  RayBundle line = rays;
  line.y.setZero();
  line.x[0] = 1e-4;  // far from the other rays, in x only
  line.weight[0] = 1e-4;
  EXPECT_TRUE(seen(line, SpotFwhm{1e-6 * std::sqrt(4.0 / 3) / 2000}).warnings.empty());
  const Seen some = seen(rays, SpotFwhm{1e-6 / 10000});
  EXPECT_TRUE(std::isfinite(some.value));
  EXPECT_TRUE(some.warnings.empty());
}

}  // namespace
}  // namespace aberfit
