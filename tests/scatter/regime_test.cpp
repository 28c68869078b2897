#include "aberfit/scatter/regime.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scatter/golden_csv.h"

using namespace aberfit;

namespace {

const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{0.4};
constexpr double kLambda = 632.8e-9;
constexpr double kPrinted = 1e-11;  // 12 digits are given

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(SceneNumbers, MatchTheGoldenNumbersOfGaussianSurfaces) {
  int rows = 0;
  for (const GoldenRow& row : read_golden("ghs_ee.csv")) {
    if (row.at("acf") != "gauss") continue;
    ++rows;
    const double l = std::stod(row.at("l_m")), sigma = std::stod(row.at("sigma_m"));
    const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda);
    EXPECT_NEAR(n.rms_height / sigma, 1.0, kPrinted);
    EXPECT_NEAR(n.g / std::stod(row.at("g")), 1.0, kPrinted);
    EXPECT_NEAR(n.rms_slope_per_axis / std::stod(row.at("slope_axis")), 1.0, kPrinted);
    EXPECT_NEAR(n.kappa / std::stod(row.at("kappa")), 1.0, kPrinted) << "sigma " << sigma;
    // The golden R has the 1/e length l in place of l_c = int C/C(0) = sqrt(pi)/2 l.
    EXPECT_NEAR(n.correlation_length / l, 0.5 * std::sqrt(std::numbers::pi), 1e-10);
    EXPECT_NEAR(n.paper_ratio_r * n.correlation_length / l / std::stod(row.at("R_paper")), 1.0, kPrinted);
    EXPECT_NEAR(1 - n.tis, std::stod(row.at("core_fraction")), kPrinted);
    // PHYSICS 7, rule 1: where rays are declared valid, ee90 and ee50 of rays and GHS agree to 10 %.
    if (n.rays_are_valid) {
      EXPECT_LT(std::abs(std::stod(row.at("ee90_geo")) / std::stod(row.at("ee90_ghs")) - 1), 0.1);
      EXPECT_LT(std::abs(std::stod(row.at("ee50_geo")) / std::stod(row.at("ee50_ghs")) - 1), 0.1);
    }
    EXPECT_EQ(n.rays_are_valid,
              std::stod(row.at("kappa")) >= 0.85);  // in this table the spot is then always 5 Airy discs
  }
  EXPECT_EQ(rows, 16);
}

TEST(SceneNumbers, MatchTheGoldenNumbersOfAKCorrelationSurface) {
  // ACF (1 + x/l) exp(-x/l) has the PSD of exponent 5 with B = 2 pi l.
  int rows = 0;
  for (const GoldenRow& row : read_golden("ghs_ee.csv")) {
    if (row.at("acf") != "c5") continue;
    ++rows;
    const double l = std::stod(row.at("l_m")), sigma = std::stod(row.at("sigma_m"));
    const KCorrelationPsd model{sigma, 2 * std::numbers::pi * l, 5.0};
    const SceneNumbers n = scene_numbers(RadialPsd(model), kParabola, kCircle, kLambda);
    EXPECT_NEAR(n.rms_slope_per_axis / std::stod(row.at("slope_axis")), 1.0, kPrinted);
    EXPECT_NEAR(n.kappa / std::stod(row.at("kappa")), 1.0, 1e-10) << "sigma " << sigma;
    EXPECT_FALSE(n.rays_are_valid);  // kappa stays below 0.8 in this table
    EXPECT_TRUE(has(n.reason, "wave optics")) << n.reason;
  }
  EXPECT_GT(rows, 4);
}

TEST(SceneNumbers, ModeCountAndSpreadFollowTheirClosedForms) {
  const double l = 0.02, sigma = 1e-7;
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda);
  // With a = (pi l)^2, S = sigma^2 a/pi exp(-a f^2): first integral sigma^2/a; second sigma^4 a^2/pi^2 * pi *
  // int u^2 exp(-2 a u) du = sigma^4 a^2/pi * 2/(2a)^3 = sigma^4/(4 pi a).
  const double a = std::pow(std::numbers::pi * l, 2), area = std::numbers::pi * 0.04;
  EXPECT_NEAR(n.n_eff / (area * (1 / (a * a)) / (1 / (4 * std::numbers::pi * a))), 1.0, 1e-10);
  EXPECT_DOUBLE_EQ(n.realisation_spread, 0.65 / std::sqrt(n.n_eff));
  EXPECT_NEAR(n.airy_ee90, 1.9014 * kLambda * 7, 1e-18);
}

TEST(SceneNumbers, RoughButShallowSlopesNeedTheAiryPattern) {
  // Long waves: kappa near 1, but a spot not much larger than the Airy disc.
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{3e-7, 0.3}), kParabola, kCircle, kLambda);
  EXPECT_GE(n.kappa, kKappaOfRays);
  EXPECT_FALSE(n.rays_are_valid);
  EXPECT_TRUE(has(n.reason, "convolved with the Airy pattern")) << n.reason;
}

TEST(SceneNumbers, TheReasonIsOneSentenceWithTheNumbersInIt) {
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{2e-7, 0.01}), kParabola, kCircle, kLambda);
  EXPECT_TRUE(n.rays_are_valid);
  EXPECT_TRUE(has(n.reason, "kappa = 0.969")) << n.reason;
  EXPECT_TRUE(has(n.reason, "339.9")) << n.reason;  // ee90_geo of the golden row [um]
  EXPECT_TRUE(has(n.reason, "geometric rays are the right model"));
  EXPECT_EQ(n.reason.back(), '.');
}

TEST(SceneNumbers, InfiniteSlopeMeansNoRays) {
  // f^-3 in two dimensions without an upper limit: finite height, infinite slope.
  const KCorrelationPsd model{1e-7, 0.1, 3.0};
  const SceneNumbers n = scene_numbers(RadialPsd(model), kParabola, kCircle, kLambda);
  EXPECT_TRUE(std::isinf(n.rms_slope_per_axis));
  EXPECT_NEAR(n.rms_height, 1e-7, 1e-17);
  EXPECT_EQ(n.kappa, 0.0);
  EXPECT_FALSE(n.rays_are_valid);
  EXPECT_TRUE(has(n.reason, "infinite")) << n.reason;
}

TEST(SceneNumbers, InfiniteHeightMeansNoVerdictForRays) {
  PowerLawPsd model;
  model.amplitude = 1e-20;
  model.exponent = 3.0;
  model.f_max = 100;
  const SceneNumbers n = scene_numbers(RadialPsd(model), kParabola, kCircle, kLambda);
  EXPECT_TRUE(std::isinf(n.rms_height));
  EXPECT_FALSE(n.rays_are_valid);
  EXPECT_TRUE(has(n.reason, "low frequency")) << n.reason;
}
