#include "aberfit/spectrum/detrend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "dabam_loader.h"

using namespace aberfit;

TEST(Detrend, PolynomialsVanishOnProfilesAndMaps) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(50, 0.1, 0.4);
  profile.value = 1 + 2 * profile.x - 3 * profile.x.cube();
  profile.value[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LT(rms(detrend(profile, {DetrendShape::kPolynomial, 3})), 1e-13);
  EXPECT_GT(rms(detrend(profile, {DetrendShape::kPolynomial, 2})), 1e-4);
  EXPECT_TRUE(std::isnan(detrend(profile, {}).value[7]));
  profile.quantity = ProfileQuantity::kSlope;  // a cubic slope belongs to a height of degree 4
  EXPECT_LT(rms(detrend(profile, {DetrendShape::kPolynomial, 4})), 1e-13);
  EXPECT_GT(rms(detrend(profile, {DetrendShape::kPolynomial, 3})), 1e-4);
  HeightMap map;
  map.pitch_x = 1, map.pitch_y = 2;
  map.height.resize(20, 30);
  for (int r = 0; r < 20; ++r)
    for (int c = 0; c < 30; ++c) map.height(r, c) = 4 + c * r - 0.1 * c * c * r;
  map.height(3, 4) = std::numeric_limits<double>::quiet_NaN();
  const double scale = rms(map);
  EXPECT_LT(rms(detrend(map, {DetrendShape::kPolynomial, 3})), 1e-13 * scale);
  EXPECT_LT(rms(detrend(map, {DetrendShape::kZernike, 3})), 1e-13 * scale);
  EXPECT_GT(rms(detrend(map, {DetrendShape::kEllipse, 9})), 1e-3 * scale);
}

TEST(Detrend, TrapezoidIntegratesALinearSlopeExactlyAcrossAHole) {
  Profile slope;
  slope.quantity = ProfileQuantity::kSlope;
  slope.x.resize(5);
  slope.x << 0, 1, 3, 4, 7;
  slope.value = 2 * slope.x;
  slope.value[2] = std::numeric_limits<double>::quiet_NaN();
  const Profile height = heights_of(slope);
  EXPECT_EQ(height.quantity, ProfileQuantity::kHeight);
  EXPECT_TRUE(std::isnan(height.value[2]));
  for (const int i : {0, 1, 3, 4}) EXPECT_NEAR(height.value[i], slope.x[i] * slope.x[i], 1e-14);
}

using DetrendOnRealData = test::DabamOnRealData;

// 161 raw slopes of an ESRF ellipse: degree 2 leaves 46 nm, degree 6 0.10 nm, an ellipse 0.19 nm.
TEST_F(DetrendOnRealData, EllipseOfDabam004IsFound) {
  const Profile height = heights_of(test::load_dabam("004"));
  EXPECT_NEAR(rms(detrend(height, {DetrendShape::kPolynomial, 2})), 46e-9, 1e-9);
  EXPECT_NEAR(rms(detrend(height, {DetrendShape::kPolynomial, 6})), 0.10e-9, 0.01e-9);
  EXPECT_LT(rms(detrend(height, {DetrendShape::kEllipse, 2})), 0.25e-9);
}
