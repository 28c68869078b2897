// RMS height about the mean over the aperture, by sums over plane waves in place of a transfer function. A
// wave of amplitude a keeps a^2 (1 - |W|^2) of its variance, with W its mean over the aperture.
#include "aberfit/theory/height_on_aperture.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "aberfit/core/quadrature.h"

namespace aberfit {
namespace {

using std::numbers::pi;

double airy(double x) { return x > 1e-8 ? 2 * boost::math::cyl_bessel_j(1, x) / x : 1; }
double sinc(double x) { return std::abs(x) > 1e-8 ? std::sin(x) / x : 1; }

// |W|^2 averaged over direction.
using MeanOfWave = std::function<double(double f)>;
MeanOfWave circle(double d) {
  return [=](double f) { return std::pow(airy(pi * f * d), 2); };
}
MeanOfWave annulus(double d, double inner) {
  const double hole = inner * inner / (d * d);
  return [=](double f) { return std::pow((airy(pi * f * d) - hole * airy(pi * f * inner)) / (1 - hole), 2); };
}
MeanOfWave rectangle(double a, double b) {
  return [=](double f) {
    double sum = 0;
    constexpr int kDirections = 2000;
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 0.5 * pi * (i + 0.5) / kDirections;
      sum += std::pow(sinc(pi * f * a * std::cos(angle)) * sinc(pi * f * b * std::sin(angle)), 2);
    }
    return sum / kDirections;
  };
}

double by_waves(const RadialPsd& psd, const MeanOfWave& mean, double from, double to) {
  double variance = 0;
  const int panels = int(std::ceil(40 * std::log(to / from)));
  for (int p = 0; p < panels; ++p) {
    const double a = from * std::pow(to / from, double(p) / panels),
                 b = from * std::pow(to / from, double(p + 1) / panels);
    const Quadrature rule = gauss_legendre(16, a, b);
    for (int i = 0; i < 16; ++i) {
      const double f = rule.nodes[i];
      variance += rule.weights[i] * 2 * pi * f * psd(f) * (1 - mean(f));
    }
  }
  return std::sqrt(variance);
}

TEST(HeightOnAperture, IsWhatEveryWaveKeepsAboutItsMean) {
  struct Case {
    std::string name;
    RadialPsd psd;
    double from, to;
  };
  const Case cases[] = {{"one cycle", RadialPsd(UniformPsd{100e-9, 2.5, 13}), 2.5, 13},
                        {"half a cycle", RadialPsd(PowerLawPsd{50e-9, {}, 3.5, 1.25, 60}), 1.25, 60},
                        {"wide", RadialPsd(KCorrelationPsd{20e-9, 0.3, 2.6, 0.5, 900}), 0.5, 900},
                        {"fine", RadialPsd(UniformPsd{10e-9, 100, 200}), 100, 200}};
  const std::pair<Aperture, MeanOfWave> apertures[] = {{CircleAperture{0.4}, circle(0.4)},
                                                       {AnnulusAperture{0.4, 0.15}, annulus(0.4, 0.15)},
                                                       {RectangleAperture{0.4, 0.2}, rectangle(0.4, 0.2)}};
  for (const Case& c : cases)
    for (const auto& [aperture, mean] : apertures) {
      const double expected = by_waves(c.psd, mean, c.from, c.to);
      EXPECT_NEAR(rms_height_on(aperture, c.psd) / expected, 1, 1e-5)
          << c.name << ", aperture " << aperture.index();
    }
  const double sigma = psd_moments(cases[1].psd).rms_height();
  EXPECT_LT(rms_height_on(CircleAperture{0.4}, cases[1].psd), 0.93 * sigma);
  EXPECT_GT(rms_height_on(CircleAperture{0.4}, cases[0].psd), 0.998 * 100e-9);
}

// Kolmogorov turbulence without an outer scale: half of 6.884 (s/r0)^(5/3), averaged over the distances s of
// two points of a disc (a beta function). The result is 1.0324 (D/r0)^(5/3) rad^2; Noll (1976) has 1.0299
// with rounded constants. The height variance is infinite.
TEST(HeightOnAperture, OfKolmogorovTurbulenceIsFinite) {
  constexpr double kDiameter = 0.4, kR0 = 0.1;
  const RadialPsd phase(PowerLawPsd{{},
                                    0.02289558710855518 * std::pow(kR0, -5.0 / 3),
                                    11.0 / 3,
                                    0,
                                    std::numeric_limits<double>::infinity()});
  const double variance = std::pow(rms_height_on(CircleAperture{kDiameter}, phase), 2);
  const auto beta = [](double a, double b) { return std::tgamma(a) * std::tgamma(b) / std::tgamma(a + b); };
  constexpr double n = 5.0 / 3;
  const double mean =
      4 / pi * 4 * (0.5 / (n + 2) * beta((n + 3) / 2, 0.5) - 0.5 * beta((n + 3) / 2, 1.5));  // in diameters
  const double expected = 0.5 * 6.883877182 * mean;
  EXPECT_NEAR(expected, 1.0324, 1e-4);
  EXPECT_NEAR(variance / std::pow(kDiameter / kR0, n) / expected, 1, 1e-5);
}

TEST(HeightOnAperture, IsInfiniteWhereHeightsOfFineRoughnessAre) {
  const RadialPsd endless(PowerLawPsd{{}, 1e-20, 1.9, 1, std::numeric_limits<double>::infinity()});
  EXPECT_TRUE(std::isinf(rms_height_on(CircleAperture{0.4}, endless)));
}

}  // namespace
}  // namespace aberfit
