#include "aberfit/theory/regime.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "golden_csv.h"

using namespace aberfit;

namespace {

const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{0.4};
constexpr double kLambda = 632.8e-9;
constexpr double kPrinted = 1e-11;  // 12 digits

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
    // PHYSICS 7: where rays are allowed, their ee90 and ee50 agree with GHS to 10 %.
    if (n.kappa_rule_allows_rays) {
      EXPECT_LT(std::abs(std::stod(row.at("ee90_geo")) / std::stod(row.at("ee90_ghs")) - 1), 0.1);
      EXPECT_LT(std::abs(std::stod(row.at("ee50_geo")) / std::stod(row.at("ee50_ghs")) - 1), 0.1);
    }
    EXPECT_EQ(n.kappa_rule_allows_rays,
              std::stod(row.at("kappa")) >= 0.85);  // the spot is then at least 5 Airy discs in this table
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
    EXPECT_FALSE(n.kappa_rule_allows_rays);  // kappa stays below 0.8 in this table
    EXPECT_TRUE(has(n.reason, "wave optics")) << n.reason;
  }
  EXPECT_GT(rows, 4);
}

TEST(SceneNumbers, ModeCountAndSpreadFollowTheirClosedForms) {
  const double l = 0.02, sigma = 1e-7;
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda);
  // With a = (pi l)^2, S = sigma^2 a/pi exp(-a f^2). The first integral is sigma^2/a; the second is sigma^4
  // a^2/pi^2 * pi * int u^2 exp(-2 a u) du = sigma^4 a^2/pi * 2/(2a)^3 = sigma^4/(4 pi a).
  const double a = std::pow(std::numbers::pi * l, 2), area = std::numbers::pi * 0.04;
  EXPECT_NEAR(n.n_eff / (area * (1 / (a * a)) / (1 / (4 * std::numbers::pi * a))), 1.0, 1e-10);
  EXPECT_NEAR(n.airy_ee90 / (1.90068797783024669 * kLambda * 7), 1, 1e-14);  // 25-digit root, over pi
}

// Fraction of the energy within v = pi D r/(lambda f) of the focus of an annulus of linear obstruction e. It
// comes from the amplitude 2 J1(v)/v - e^2 2 J1(e v)/(e v) by Simpson's rule, without a transfer function.
double annulus_energy(double v, double e) {
  const auto density = [e](double t) {
    if (t == 0) return 0.0;
    const double a =
        2 * std::cyl_bessel_j(1, t) / t - (e > 0 ? 2 * e * std::cyl_bessel_j(1, e * t) / t : 0.0);
    return a * a * t;
  };
  constexpr int kSteps = 2000;
  double sum = density(0) + density(v);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 ? 4 : 2) * density(v * i / kSteps);
  return sum * v / (3 * kSteps) / (2 * (1 - e * e));
}

TEST(AiryEe90, HoldsNinetyPercentOfTheLightOfCirclesAndAnnuli) {
  constexpr double kAllowed = 1e-9;  // Simpson: (v/2000)^4; largest seen 2e-11
  for (const double e : {0.0, 0.1, 0.3, 0.6, 0.9}) {
    const Aperture aperture = e > 0 ? Aperture(AnnulusAperture{0.4, 0.4 * e}) : Aperture(CircleAperture{0.4});
    const double v = std::numbers::pi * 0.4 * airy_ee90(kParabola, aperture, kLambda) / (kLambda * 2.8);
    EXPECT_NEAR(annulus_energy(v, e), 0.9, kAllowed) << e;
  }
}

TEST(AiryEe90, OfASquareLiesBetweenItsInscribedAndCircumscribedCircles) {
  const double square = airy_ee90(kParabola, RectangleAperture{0.3, 0.3}, kLambda);
  EXPECT_LT(square, airy_ee90(kParabola, CircleAperture{0.3}, kLambda) * 1.2);
  EXPECT_GT(square, airy_ee90(kParabola, CircleAperture{0.3 * std::numbers::sqrt2}, kLambda));
  // The pattern of a square is sinc^2(pi a x) sinc^2(pi a y), summed over the disc on a fine grid.
  const double scale = 0.3 / (kLambda * 2.8), radius = square * scale;
  constexpr int kCells = 1500;
  const auto sinc2 = [](double t) { return t == 0 ? 1.0 : std::pow(std::sin(t) / t, 2); };
  double sum = 0;
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const double x = (i + 0.5) * radius / kCells, y = (j + 0.5) * radius / kCells;
      if (x * x + y * y < radius * radius) sum += sinc2(std::numbers::pi * x) * sinc2(std::numbers::pi * y);
    }
  EXPECT_NEAR(4 * sum * std::pow(radius / kCells, 2), 0.9,
              1e-4);  // grid cells at the edge: circumference x pitch x density
}

TEST(SceneNumbers, TheThresholdsNameARegime) {
  const auto of = [](double sigma, double l) {
    return regime(scene_numbers(RadialPsd(GaussianPsd{sigma, l}), kParabola, kCircle, kLambda));
  };
  EXPECT_EQ(of(2e-7, 0.01), FocusModel::kRays);
  EXPECT_EQ(of(3e-7, 0.3), FocusModel::kWaves);
  EXPECT_EQ(of(2e-8, 0.01), FocusModel::kWaves);
}

TEST(SceneNumbers, RoughButShallowSlopesNeedWaves) {
  // Long waves: kappa is near 1, but the spot is not much larger than the Airy disc.
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{3e-7, 0.3}), kParabola, kCircle, kLambda);
  EXPECT_GE(n.kappa, kKappaOfRays);
  EXPECT_FALSE(n.kappa_rule_allows_rays);
  EXPECT_TRUE(has(n.reason, "wave optics is needed")) << n.reason;
}

TEST(SceneNumbers, TheReasonIsOneSentenceWithTheNumbersInIt) {
  const SceneNumbers n = scene_numbers(RadialPsd(GaussianPsd{2e-7, 0.01}), kParabola, kCircle, kLambda);
  EXPECT_TRUE(n.kappa_rule_allows_rays);
  EXPECT_TRUE(has(n.reason, "kappa = 0.969")) << n.reason;
  EXPECT_TRUE(has(n.reason, "339.9")) << n.reason;  // ee90_geo of the golden row [um]
  EXPECT_TRUE(has(n.reason, "geometric rays are the right model"));
  EXPECT_EQ(n.reason.back(), '.');
}

TEST(SceneNumbers, InfiniteSlopeMeansNoRays) {
  // f^-3 in two dimensions without an upper limit has a finite height and an infinite slope.
  const KCorrelationPsd model{1e-7, 0.1, 3.0};
  const SceneNumbers n = scene_numbers(RadialPsd(model), kParabola, kCircle, kLambda);
  EXPECT_TRUE(std::isinf(n.rms_slope_per_axis));
  EXPECT_NEAR(n.rms_height, 1e-7, 1e-17);
  EXPECT_EQ(n.kappa, 0.0);
  EXPECT_FALSE(n.kappa_rule_allows_rays);
  EXPECT_TRUE(has(n.reason, "infinite")) << n.reason;
}

TEST(SceneNumbers, InfiniteHeightMeansNoVerdictForRays) {
  PowerLawPsd model;
  model.amplitude = 1e-20;
  model.exponent = 3.0;
  model.f_max = 100;
  const SceneNumbers n = scene_numbers(RadialPsd(model), kParabola, kCircle, kLambda);
  EXPECT_TRUE(std::isinf(n.rms_height));
  EXPECT_FALSE(n.kappa_rule_allows_rays);
  EXPECT_TRUE(has(n.reason, "low frequency")) << n.reason;
}
