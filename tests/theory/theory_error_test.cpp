#include "aberfit/theory/theory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/theory/height_on_aperture.h"
#include "aberfit/theory/regime.h"
#include "aberfit/theory/scattering_band.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kLambda = 632.8e-9;
const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{0.4};
const double kTenDegrees = std::sin(pi / 18);
const double kInf = std::numeric_limits<double>::infinity();

}  // namespace

TEST(ScatteringBand, CutsWhatIsShorterThanTheWavelength) {
  // Fraction of a k-correlation variance beyond F: (1 + (B F)^2)^(1 - c/2).
  const double B = 0.1, c = 2.6, F = 1 / kLambda;
  const ScatteringBand band = scattering_band(RadialPsd(KCorrelationPsd{40e-9, B, c, 0, kInf}), kLambda);
  const double share = std::pow(1 + std::pow(B * F, 2), 1 - 0.5 * c);
  EXPECT_NEAR(band.cut_share / share, 1, 1e-9);
  EXPECT_NEAR(band.rms_height, 40e-9 * std::sqrt(1 - share), 1e-17);
  EXPECT_EQ(band.psd.f_max(), F);
  EXPECT_EQ(scattering_band(RadialPsd(GaussianPsd{1e-8, 0.01}), kLambda).cut_share, 0);
  EXPECT_EQ(scattering_band(RadialPsd(UniformPsd{1e-8, 1, 1e5}), kLambda).psd.f_max(), 1e5);
  const ScatteringBand endless = scattering_band(RadialPsd(PowerLawPsd{{}, 1e-20, 2.5, 0, kInf}), kLambda);
  EXPECT_TRUE(std::isinf(endless.rms_height));
  EXPECT_GT(endless.cut_share, 0);
  EXPECT_LT(endless.cut_share, 1e-4);
}

TEST(ScatteringBand, IsWhatTheNumbersOfLightAreMadeOf) {
  const RadialPsd psd(KCorrelationPsd{40e-9, 0.1, 2.4, 0, 4e7});
  const ScatteringBand band = scattering_band(psd, kLambda);
  ASSERT_GT(band.cut_share, 1e-3);
  const SceneNumbers numbers = scene_numbers(psd, kParabola, kCircle, kLambda);
  EXPECT_NEAR(numbers.rms_height, 40e-9, 1e-17);
  EXPECT_DOUBLE_EQ(numbers.relevant_rms_height, band.rms_height);
  EXPECT_DOUBLE_EQ(numbers.cut_share, band.cut_share);
  EXPECT_DOUBLE_EQ(numbers.g, 4 * pi * band.rms_height / kLambda);
  const GeneralisedHarveyShack waves(psd, kParabola, kCircle, kLambda);
  EXPECT_DOUBLE_EQ(waves.g(), numbers.g);
  EXPECT_DOUBLE_EQ(waves.cut_share(), band.cut_share);
  EXPECT_DOUBLE_EQ(waves(RmsHeight{}), rms_height_on(kCircle, psd));  // a property of the surface
}

TEST(TheoryError, CountsTheLightBeyondTenDegrees) {
  // g = 0.01, single scattering to g^2/2: (4 pi/lambda)^2 int S beyond sin(10 degrees)/lambda.
  const double g = 0.01, l = 1e-6, sigma = g * kLambda / (4 * pi);
  const TheoryError error = theory_error(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda);
  const double expected = g * g * std::exp(-std::pow(pi * l * kTenDegrees / kLambda, 2));
  EXPECT_NEAR(error.beyond_ten_degrees / expected, 1, 1e-3);
  EXPECT_TRUE(error.applies);
  EXPECT_TRUE(error.clause.empty());
  EXPECT_NEAR(error.paraxial, 1.0 / (32 * 49), 1e-15);
  // 90 % of the scattered energy: exp(-(pi l f)^2) = 0.1.
  EXPECT_NEAR(error.small_angle / (0.5 * std::pow(kLambda * std::sqrt(std::log(10.0)) / (pi * l), 2)), 1,
              1e-2);
  const TheoryError rough = theory_error(RadialPsd(GaussianPsd{10 * sigma, l}), kParabola, kCircle, kLambda);
  EXPECT_NEAR(rough.beyond_ten_degrees / (100 * expected), 1, 2e-2);
  EXPECT_TRUE(rough.applies && rough.wide_angles);  // 0.47 %
  EXPECT_NE(rough.clause.find("0.1 % of the energy"), std::string::npos) << rough.clause;
  EXPECT_FALSE(error.wide_angles);
}

TEST(TheoryError, OfSteepSlopesIsThatOfRays) {
  // g = 60: rays turn by twice the slope, so the sine of the angle is Gaussian.
  const double g = 60, sigma = g * kLambda / (4 * pi), slope = 0.05, l = sigma * std::numbers::sqrt2 / slope;
  const TheoryError error = theory_error(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda);
  EXPECT_NEAR(error.beyond_ten_degrees, std::exp(-0.5 * std::pow(kTenDegrees / (2 * slope), 2)), 0.01);
  EXPECT_FALSE(error.applies);
}

TEST(TheoryError, MindsShortWavelengthsAndRefusesWhatDoesNotExist) {
  const TheoryError error = theory_error(RadialPsd(GaussianPsd{1e-10, 1e-3}), kParabola, kCircle, 13.5e-9);
  EXPECT_TRUE(error.applies);
  EXPECT_TRUE(error.mostly_grazing);
  EXPECT_NE(error.of_grazing.find("grazing"), std::string::npos);
  EXPECT_THROW(theory_error(RadialPsd(PowerLawPsd{{}, 1e-20, 4.0, 0, 100}), kParabola, kCircle, kLambda),
               ComputationError);
  const TheoryError endless =
      theory_error(RadialPsd(PowerLawPsd{{}, 1e-20, 3.0, 0, 100}), kParabola, kCircle, kLambda);
  EXPECT_TRUE(endless.applies);
}

TEST(RayErrorInLight, FallsWithTheRoughnessAndIsWhatItSays) {
  double last = 1e300;
  for (const double g : {1.0, 4.0, 20.0, 200.0}) {
    const RadialPsd psd(GaussianPsd{g * kLambda / (4 * pi), 0.02});
    const double slope = psd_moments(psd).rms_slope_per_axis();
    const GeneralisedHarveyShack light(psd, kParabola, kCircle, kLambda);
    const GeometricHarveyShack rays(kParabola, kCircle, slope, Convention::kPhysical, 0);
    const double error = ray_error_in_light(light, rays, {0.2, 0.5, 0.9}, {0, 1e-3});
    EXPECT_LT(error, last) << g;
    last = error;
    // A Gaussian spot has r dE/dr = 2 (1 - p) ln(1/(1 - p)).
    const double radius = light.encircled_energy_radius(0.5, 0);
    const double alone = ray_error_in_light(light, rays, {0.5}, {0});
    const double slope_of_light = radius * light.at_plane(0).encircled_energy_slope(radius);
    EXPECT_NEAR(alone * std::max(0.35, slope_of_light), std::abs(rays.encircled_energy(radius, 0) - 0.5),
                1e-12);
    if (g == 200) {
      EXPECT_NEAR(slope_of_light, std::log(2.0), 2e-3);
    }
  }
  EXPECT_LT(last, 1e-3);
}
