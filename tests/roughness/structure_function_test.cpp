#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/roughness/psd.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kRelative = 1e-11;  // from the header
using Wide = boost::multiprecision::cpp_bin_float_100;
const std::vector<double> kDistances = {1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 0.01, 0.0317, 0.1, 0.4};

double at(const RadialPsd& psd, double r) {
  return structure_function(psd, Eigen::ArrayXd::Constant(1, r))[0];
}

}  // namespace

TEST(StructureFunction, OfAGaussianIsExpm1AlsoByQuadrature) {
  const double s = 1e-7, l = 0.01;
  const RadialPsd closed(GaussianPsd{s, l}), banded = closed.band(0, 1e5);
  for (const double r : kDistances) {
    const double truth = -s * s * std::expm1(-r * r / (l * l));
    EXPECT_NEAR(at(closed, r) / truth, 1, 1e-14) << r;
    EXPECT_NEAR(at(banded, r) / truth, 1, kRelative) << r;
  }
}

TEST(StructureFunction, OfKCorrelationsAgreesWithTheBesselFormInHundredDigits) {
  const double s = 1e-7, B = 0.02;
  for (const double c : {2.2, 2.5, 3.0, 3.6, 4.0, 4.001, 5.0, 6.0, 8.0, 11.3}) {
    const RadialPsd psd(KCorrelationPsd{s, B, c, 0, kInf});
    for (const double r : {1e-9, 1e-6, 1e-4, 1e-3, 6e-3, 0.0317, 0.4}) {
      const Wide nu = Wide(c) / 2 - 1, a = 2 * boost::math::constants::pi<Wide>() * Wide(r) / Wide(B);
      const Wide matern = 2 / boost::math::tgamma(nu) * pow(a / 2, nu) * boost::math::cyl_bessel_k(nu, a);
      EXPECT_NEAR(at(psd, r) / (s * s * double(1 - matern)), 1, kRelative) << c << " " << r;
    }
  }
}

TEST(StructureFunction, OfAUniformBandAndOfItsTwinsByQuadratureAgree) {
  const double s = 1e-7, a = 2.5, b = 1e4;
  const RadialPsd uniform(UniformPsd{s, a, b}), power(PowerLawPsd{s, {}, 0.0, a, b});
  const RadialPsd table(TablePsd{{a, b}, {uniform(3), uniform(3)}});
  for (const double r : kDistances) {
    // If 1 - J0 has no cancellation, the difference of autocorrelations is exact.
    const double truth = at(uniform, r);
    if (r > 3e-3) {
      EXPECT_NEAR(truth / (s * s - autocorrelation(uniform, r)), 1, 1e-10) << r;
    }
    // Slope variance: C(0) - C(r) = r^2/4 int (2 pi f)^2 S for small r.
    if (r < 1e-8) {
      EXPECT_NEAR(truth / (0.25 * r * r * psd_moments(uniform).slope_variance), 1, 1e-7) << r;
    }
    EXPECT_NEAR(at(power, r) / truth, 1, kRelative) << r;
    EXPECT_NEAR(at(table, r) / truth, 1, kRelative) << r;
  }
}

TEST(StructureFunction, OfWidePowerLawsAndTablesIsTheDifferenceOfAutocorrelations) {
  // The autocorrelation integrates the same S by Filon's rule, panel by panel.
  for (const double exponent : {1.8, 2.5, 3.1, 6.0}) {
    const RadialPsd power(PowerLawPsd{1e-7, {}, exponent, 2.5, 1e4});
    std::vector<double> f, s;
    for (int i = 0; i < 60; ++i) {
      f.push_back(2.5 * std::pow(4000.0, i / 59.0));
      s.push_back(power(std::min(f.back(), 9999.0)) * (1 + 0.3 * std::sin(7.3 * i)));
    }
    for (const RadialPsd& psd : {power, RadialPsd(TablePsd{f, s})}) {
      const double variance = psd_moments(psd).height_variance;
      for (const double r : {1e-3, 3.3e-3, 0.0123, 0.05, 0.17, 0.4})
        EXPECT_NEAR(at(psd, r) / variance, 1 - autocorrelation(psd, r) / variance, kRelative)
            << exponent << " " << r;
    }
  }
}

TEST(StructureFunction, OfLongRaggedTablesIsTheDifferenceOfAutocorrelations) {
  // Closely spaced points, in log and linear steps: small r merges panels, large r uses waves.
  for (const bool even : {false, true}) {
    std::vector<double> f, s;
    for (int i = 0; i < 400; ++i) {
      f.push_back(even ? 2.5 + 9997.5 * i / 399.0 : 2.5 * std::pow(4000.0, i / 399.0));
      s.push_back(std::pow(f.back(), -2.2) * std::exp(0.4 * std::sin(7.3 * i * (1 + 0.01 * i))));
    }
    const RadialPsd psd{TablePsd{f, s}};
    const double variance = psd_moments(psd).height_variance;
    Eigen::ArrayXd r(12);
    r << 1e-3, 3.3e-3, 7e-3, 0.0123, 0.02, 0.027, 0.05, 0.11, 0.17, 0.21, 0.33, 0.4;
    const Eigen::ArrayXd together = structure_function(psd, r), truth = variance - autocorrelation(psd, r);
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      EXPECT_NEAR(together[i] / variance, truth[i] / variance, kRelative) << even << " " << r[i];
      EXPECT_NEAR(at(psd, r[i]) / together[i], 1, kRelative) << even << " " << r[i];
    }
  }
}

TEST(StructureFunction, OfASplitFractalSumsToTheWhole) {
  for (const double c : {2.1, 2.6, 3.4}) {
    const RadialPsd whole(KCorrelationPsd{1e-7, 0.02, c, 0, kInf});
    for (const double r : {1e-9, 1e-5, 1e-3, 0.1})
      EXPECT_NEAR((at(whole.band(0, 130), r) + at(whole.band(130, kInf), r)) / at(whole, r), 1, kRelative)
          << c << " " << r;
  }
}

TEST(StructureFunction, OfKolmogorovTurbulenceIsFried) {
  // The reference is half of 6.883877182 (r/r0)^(5/3) for S = 0.02289558710855518 r0^(-5/3) f^(-11/3), whose
  // variance diverges.
  constexpr double kPrinted = 2e-10;  // digits of the two constants
  const double r0 = 0.15, amplitude = 0.02289558710855518 * std::pow(r0, -5.0 / 3);
  const RadialPsd whole(PowerLawPsd{{}, amplitude, 11.0 / 3, 0, kInf});
  for (const double r : {1e-6, 1e-3, 0.1, 10.0, 1e4})
    EXPECT_NEAR(at(whole, r) / (0.5 * 6.883877182 * std::pow(r / r0, 5.0 / 3)), 1, kPrinted) << r;
  // Many r share panels. The cut in two has a lower part that alone diverges.
  Eigen::ArrayXd r(3);
  r << 1e-5, 0.3, 2e3;
  const Eigen::ArrayXd all = structure_function(whole, r);
  const Eigen::ArrayXd split =
      structure_function(whole.band(0, 1.7), r) + structure_function(whole.band(1.7, kInf), r);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(all[i] / (0.5 * 6.883877182 * std::pow(r[i] / r0, 5.0 / 3)), 1, kPrinted);
    EXPECT_NEAR(split[i] / all[i], 1, kRelative);
  }
}

TEST(StructureFunction, IsZeroAtZeroAndInfiniteWhereItDoesNotExist) {
  EXPECT_EQ(at(RadialPsd(GaussianPsd{1e-7, 0.01}), 0), 0);
  EXPECT_TRUE(std::isinf(at(RadialPsd(PowerLawPsd{{}, 0.02, 4.0, 0, 100}), 0.1)));
  EXPECT_TRUE(std::isinf(at(RadialPsd(PowerLawPsd{{}, 0.02, 1.9, 1, kInf}), 0.1)));
}
