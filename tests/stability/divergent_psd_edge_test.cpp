// PSDs whose integrals diverge: power laws with a band that opens at either end. Truth: the elementary
// integrals, written with expm1 so that they pass through the exponents where a power becomes a logarithm.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/roughness/psd_integrals.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kOpen = std::numeric_limits<double>::infinity();

// 2 pi int_a^b (2 pi f)^power f^(1 - b) df with amplitude 1; infinite where it does not exist.
double integral(double exponent, int power, double a, double b) {
  const double p = power + 2 - exponent;
  if ((a == 0 && p <= 0) || (b == kOpen && p >= 0)) return kOpen;
  const double factor = std::pow(2 * std::numbers::pi, power + 1);
  if (a == 0) return factor * std::pow(b, p) / p;
  if (b == kOpen) return -factor * std::pow(a, p) / p;
  const double ratio = std::log(b / a);
  return factor * std::pow(a, p) * (p == 0 ? ratio : std::expm1(p * ratio) / p);
}

struct Moment {
  double found, truth;
  bool refused = false;
};
Moment moment(double exponent, int power, double a, double b) {
  PowerLawPsd model;
  model.amplitude = 1, model.exponent = exponent, model.f_min = a, model.f_max = b;
  if (!psd_problem(model).empty()) return {std::nan(""), integral(exponent, power, a, b), true};
  const PsdMoments moments = psd_moments(RadialPsd(model));
  return {power == 0 ? moments.height_variance : moments.slope_variance, integral(exponent, power, a, b)};
}

// If the integral exists, psd.h promises a relative error of 1e-12; if not, it returns infinity.
EdgeRow row_of(double parameter, const Moment& m, double avoided = std::nan("")) {
  if (m.refused) return {parameter, std::nan(""), 1e-12, true};
  const bool told = std::isinf(m.found);
  return {parameter, told ? (std::isinf(m.truth) ? std::nan("") : kOpen) : std::abs(m.found / m.truth - 1),
          1e-12, told, avoided};
}

TEST(StabilityEdge, HeightOfABandThatOpensBelow) {
  Edge edge("psd_exponent_low_end", "exponent of the PSD, band 0 .. 100 /m [1]",
            "relative error of the height variance [1]");
  edge.linear_parameter();
  for (const double exponent :
       {0.5, 1.0, 1.5, 1.9, 1.99, 1.9999, 2.0, 2.0001, 2.01, 2.5, 3.0, 11.0 / 3, 4.0, 4.5}) {
    const Moment m = moment(exponent, 0, 0, 100);
    EXPECT_EQ(std::isinf(m.found), exponent >= 2) << exponent;
    // A band from 1e-6 /m, which looks low enough, gives a number for every exponent.
    edge.add(row_of(exponent, m, std::abs(integral(exponent, 0, 1e-6, 100) / m.truth - 1)));
  }
  edge.expect();
}

TEST(StabilityEdge, SlopeOfABandThatDoesNotEnd) {
  Edge edge("psd_exponent_high_end", "exponent of the PSD, band 1 /m .. infinity [1]",
            "relative error of the slope variance [1]");
  edge.linear_parameter();
  for (const double exponent :
       {1.0, 2.0, 2.5, 3.0, 11.0 / 3, 3.9, 3.99, 4.0, 4.0001, 4.01, 4.1, 4.5, 5.0, 6.0, 8.0}) {
    const Moment m = moment(exponent, 2, 1, kOpen);
    EXPECT_EQ(std::isinf(m.found), exponent <= 4) << exponent;
    edge.add(row_of(exponent, m, std::abs(integral(exponent, 2, 1, 1e6) / m.truth - 1)));
  }
  edge.expect();
}

TEST(StabilityEdge, HeightAsTheLowEndGoesToZero) {
  // With exponent 3 the height variance grows without limit, as 1/f_min.
  Edge edge("psd_low_end_to_zero", "f_min of a band up to 100 /m, exponent 3 [1/m]",
            "relative error of the height variance [1]");
  double before = 0;
  for (const double f_min : {10.0, 1.0, 1e-2, 1e-4, 1e-8, 1e-16, 1e-32, 1e-100, 0.0}) {
    const Moment m = moment(3, 0, f_min, 100);
    EXPECT_GT(m.found, before);
    if (f_min > 0 && f_min < 1e-2) {
      EXPECT_NEAR(m.found * f_min / (2 * std::numbers::pi), 1, 1e-3);
    }
    before = m.found;
    edge.add(row_of(f_min > 0 ? f_min : 1e-110, m));
  }
  edge.expect();
}

TEST(StabilityEdge, SlopeAsTheHighEndGoesToInfinity) {
  // With exponent 4 the divergence is logarithmic, the slowest one.
  Edge edge("psd_high_end_to_infinity", "f_max of a band from 1 /m, exponent 4 [1/m]",
            "relative error of the slope variance [1]");
  for (const double f_max : {10.0, 1e2, 1e4, 1e8, 1e16, 1e30, 1e31, 1e100, kOpen})
    edge.add(row_of(std::isinf(f_max) ? 1e110 : f_max, moment(4, 2, 1, f_max)));
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
