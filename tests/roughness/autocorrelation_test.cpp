#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/roughness/psd.h"

using namespace aberfit;
using std::numbers::pi;

namespace {
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kAcf = 1e-11;  // relative to C(0), from the header
const std::vector<double> kDistances = {1e-12, 1e-6, 1e-4, 1e-3, 3e-3, 0.01, 0.0317, 0.1, 0.2, 0.4, 3.0};
}  // namespace

TEST(Autocorrelation, OfAGaussianIsGaussianAlsoByQuadrature) {
  const double s = 1e-7, l = 0.01;
  const RadialPsd closed(GaussianPsd{s, l});
  const RadialPsd banded = closed.band(0, 1e5);  // S there is exp(-1e7), so quadrature must give the same ACF
  for (const double r : kDistances) {
    const double truth = s * s * std::exp(-r * r / (l * l));
    EXPECT_NEAR(autocorrelation(closed, r), truth, 1e-14 * s * s) << r;
    EXPECT_NEAR(autocorrelation(banded, r), truth, kAcf * s * s) << r;
  }
}

TEST(Autocorrelation, OfAKCorrelationWithExponentThreeIsExponential) {
  // nu = 1/2: sqrt(a) K_1/2(a) is proportional to exp(-a).
  const double s = 1e-7, B = 0.02;
  const RadialPsd closed(KCorrelationPsd{s, B, 3.0, 0, kInf});
  // The two halves of the band have no closed form, but their sum has.
  const RadialPsd below = closed.band(0, 130), above = closed.band(130, kInf);
  for (const double r : kDistances) {
    const double truth = s * s * std::exp(-2 * pi * r / B);
    EXPECT_NEAR(autocorrelation(closed, r), truth, 1e-13 * s * s) << r;
    EXPECT_NEAR(autocorrelation(below, r) + autocorrelation(above, r), truth, kAcf * s * s) << r;
  }
}

TEST(Autocorrelation, OfASlowlyFallingKCorrelationAgreesWithItsBesselForm) {
  for (const double c : {2.1, 2.5, 4.4, 30.0}) {
    const double s = 1e-7, B = 0.02;
    const RadialPsd closed(KCorrelationPsd{s, B, c, 0, kInf});
    for (const double r : kDistances) {
      const double parts =
          autocorrelation(closed.band(0, 130), r) + autocorrelation(closed.band(130, kInf), r);
      EXPECT_NEAR(autocorrelation(closed, r), parts, kAcf * s * s) << c << " " << r;
    }
  }
}

TEST(Autocorrelation, OfAUniformBandIsADifferenceOfDiscs) {
  const double s = 1e-7, a = 2.5, b = 1e6;
  const RadialPsd whole(UniformPsd{s, a, b});
  const double level = s * s / (pi * (b * b - a * a));
  for (const double r : kDistances) {
    const auto disc = [r](double f) { return f * boost::math::cyl_bessel_j(1, 2 * pi * r * f) / r; };
    const double truth = level * (disc(b) - disc(a));
    EXPECT_NEAR(autocorrelation(whole, r), truth, 1e-13 * s * s) << r;
  }
  // A power law of exponent 0 is the same PSD without a closed form. J0 oscillates 3e6 times at r = 3 m.
  const RadialPsd power(PowerLawPsd{s, {}, 0.0, a, b});
  for (const double r : kDistances)
    EXPECT_NEAR(autocorrelation(power, r), autocorrelation(whole, r), kAcf * s * s) << r;
}

TEST(Autocorrelation, AtZeroIsTheHeightVarianceForEveryModel) {
  TablePsd table;
  for (int i = 0; i < 40; ++i) {
    table.frequency.push_back(2 * std::pow(1.2, i));
    table.psd.push_back(1e-17 * std::pow(table.frequency.back(), -1.5) * (1 + 0.3 * std::sin(7.0 * i)));
  }
  const std::vector<PsdModel> models = {UniformPsd{1e-7, 2, 40},
                                        KCorrelationPsd{1e-7, 0.1, 2.4, 1, 1e5},
                                        PowerLawPsd{1e-7, {}, 2.4, 1, 1e5},
                                        GaussianPsd{1e-7, 0.01},
                                        table,
                                        SumPsd{{UniformPsd{1e-7, 2, 40}, table}}};
  for (const PsdModel& model : models) {
    const RadialPsd psd(model);
    const double variance = psd_moments(psd).height_variance;
    EXPECT_DOUBLE_EQ(autocorrelation(psd, 0), variance);
    EXPECT_NEAR(autocorrelation(psd, 1e-12), variance, 1e-11 * variance);
    for (const double r : kDistances) EXPECT_LE(std::abs(autocorrelation(psd, r)), variance * (1 + 1e-12));
  }
}

TEST(Autocorrelation, OfATableAgreesWithBruteForce) {
  TablePsd table{{2, 3, 5.5, 30, 41}, {3e-17, 5e-17, 1e-17, 2e-18, 4e-19}};
  const RadialPsd psd(table);
  for (const double r : {0.001, 0.05, 0.3, 2.0}) {
    // Composite midpoint rule in log f per table interval, with one Richardson step; error of order h^4.
    const auto midpoint = [&](int n) {
      double sum = 0;
      for (std::size_t i = 0; i + 1 < table.frequency.size(); ++i) {
        const double h = std::log(table.frequency[i + 1] / table.frequency[i]) / n;
        for (int k = 0; k < n; ++k) {
          const double f = table.frequency[i] * std::exp((k + 0.5) * h);
          sum += 2 * pi * h * f * f * psd(f) * boost::math::cyl_bessel_j(0, 2 * pi * f * r);
        }
      }
      return sum;
    };
    const double coarse = midpoint(10000), fine = midpoint(20000);
    EXPECT_NEAR(autocorrelation(psd, r), fine + (fine - coarse) / 3, 1e-11 * autocorrelation(psd, 0)) << r;
  }
}

TEST(Autocorrelation, IsInfiniteWithoutAFiniteHeightVariance) {
  EXPECT_TRUE(std::isinf(autocorrelation(RadialPsd(PowerLawPsd{{}, 0.02, 11.0 / 3, 0, kInf}), 0.1)));
}

TEST(Autocorrelation, AtManyDistancesIsThatAtEach) {
  const RadialPsd psd(
      SumPsd{{KCorrelationPsd{1e-7, 0.02, 2.6, 0.5, kInf}, TablePsd{{1, 3, 40}, {1e-17, 4e-17, 1e-18}}}});
  Eigen::ArrayXd r(6);
  r << 0.3, 0, 1e-3, 1e-9, 5, 0.02;
  const Eigen::ArrayXd all = autocorrelation(psd, r);
  for (int i = 0; i < r.size(); ++i)
    EXPECT_NEAR(all[i], autocorrelation(psd, r[i]), kAcf * autocorrelation(psd, 0)) << r[i];
}

TEST(CorrelationLength, MatchesTheClosedForms) {
  // Gaussian: int exp(-(r/l)^2) dr = sqrt(pi) l / 2. Exponential ACF: B / (2 pi). Uniform: 2 pi (b-a)/(2 pi)
  // / (pi (b^2-a^2)) = 1/(pi (a+b)).
  EXPECT_NEAR(correlation_length(RadialPsd(GaussianPsd{1e-7, 0.01})) / (0.5 * std::sqrt(pi) * 0.01), 1,
              1e-12);
  EXPECT_NEAR(correlation_length(RadialPsd(KCorrelationPsd{1e-7, 0.02, 3, 0, kInf})) / (0.02 / (2 * pi)), 1,
              1e-12);
  EXPECT_NEAR(correlation_length(RadialPsd(UniformPsd{1e-7, 2.5, 39.92})) * pi * 42.42, 1, 1e-12);
  EXPECT_TRUE(std::isinf(correlation_length(RadialPsd(PowerLawPsd{1e-7, {}, 1.2, 0, 10}))));
  EXPECT_TRUE(std::isnan(correlation_length(RadialPsd(PowerLawPsd{{}, 1, 3, 0, 10}))));
}
