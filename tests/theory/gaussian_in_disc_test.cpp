#include "aberfit/theory/gaussian_in_disc.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <numbers>

using namespace aberfit;

namespace {

const DiscRules& rules() {
  static const DiscRules r;
  return r;
}

constexpr double kPromise = 1e-13;  // promised in the header
// Second method: polar integration of the two-dimensional density about the disc's centre, with the periodic
// trapezoidal rule over angle and Gauss-Kronrod panels over radius.
double polar_integral(double radius, double offset, double sr, double st) {
  const auto ring = [&](double rho) {
    const int n = 240;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.5) / n;
      const double u = (rho * std::cos(angle) - offset) / sr, v = rho * std::sin(angle) / st;
      sum += std::exp(-0.5 * (u * u + v * v));
    }
    return rho * sum / (n * sr * st);
  };
  double total = 0;
  const int panels = 8;
  for (int i = 0; i < panels; ++i)
    total += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(ring, radius * i / panels,
                                                                           radius * (i + 1) / panels, 0);
  return total;
}

}  // namespace

TEST(GaussianInDisc, CentredCircularSpotIsRayleigh) {
  for (double ratio = 1e-3; ratio < 12; ratio *= 1.07)
    EXPECT_NEAR(gaussian_in_disc(ratio * 2e-5, 0.0, 2e-5, 2e-5, rules()).value,
                -std::expm1(-0.5 * ratio * ratio), kPromise)
        << ratio;
}

TEST(GaussianInDisc, OffsetCircularSpotIsNonCentralChiSquared) {
  double worst = 0;
  for (const double offset :
       {1e-10, 1e-3, 0.1, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 8.0, 8.6, 10.0, 16.0, 17.5, 30.0})
    for (double radius = 0.01; radius < 60; radius *= 1.05) {
      const boost::math::non_central_chi_squared_distribution<double> truth(2.0, offset * offset);
      const double error =
          gaussian_in_disc(radius, offset, 1.0, 1.0, rules()).value - cdf(truth, radius * radius);
      worst = std::max(worst, std::abs(error));
      ASSERT_LT(std::abs(error), kPromise) << "radius " << radius << " offset " << offset;
    }
  RecordProperty("worst", std::to_string(worst * 1e15) + "e-15");
}

TEST(GaussianInDisc, SmallSpotAtTheEdgeOfALargeDiscSeesAStraightEdgeWithSmallCurvature) {
  // Edge at distance d from the spot: Phi(d) - phi(d)/(2 radius) + O(1/radius^2) for unit sigmas.
  for (const double radius : {1e4, 1e5, 1e6})
    for (const double d : {-6.0, -2.0, -0.5, 0.0, 0.3, 1.0, 4.0}) {
      const double straight = 0.5 * std::erfc(-d / std::numbers::sqrt2);
      const double curvature = std::exp(-0.5 * d * d) / std::sqrt(2 * std::numbers::pi) / (2 * radius);
      const double rounding = 1e-16 * radius;  // of radius - offset
      EXPECT_NEAR(gaussian_in_disc(radius, radius - d, 1.0, 1.0, rules()).value, straight - curvature,
                  1.0 / (radius * radius) + kPromise + rounding);
    }
}

TEST(GaussianInDisc, EllipticSpotMatchesPolarIntegration) {
  for (const double st : {0.4, 0.9, 1.0, 1.3, 3.0})
    for (const double offset : {0.0, 0.7, 3.0, 9.0})
      for (const double radius : {0.3, 1.0, 2.5, 6.0, 9.0, 14.0})
        EXPECT_NEAR(gaussian_in_disc(radius, offset, 1.0, st, rules()).value,
                    polar_integral(radius, offset, 1.0, st), 3 * kPromise)
            << "radius " << radius << " offset " << offset << " ratio " << st;
}

TEST(GaussianInDisc, DerivativesMatchCentralDifferences) {
  const double h = 1e-4;
  const auto value = [&](double r, double a, double sr, double st) {
    return gaussian_in_disc(r, a, sr, st, rules()).value;
  };
  // Fourth-order differences: truncation ~ h^4, rounding 1e-13 / h.
  const auto difference = [&](auto f) { return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h); };
  const double tolerance = 5e-9;
  for (const double st : {0.8, 1.0, 1.2})
    for (const double a : {-2.0, 0.0, 0.5, 4.0, 12.0})
      for (const double r : {0.5, 2.0, 5.0, 9.5, 12.5}) {
        const DiscShare s = gaussian_in_disc(r, a, 1.0, st, rules());
        EXPECT_NEAR(s.d_radius, difference([&](double d) { return value(r + d, a, 1.0, st); }), tolerance);
        EXPECT_NEAR(s.d_offset, difference([&](double d) { return value(r, a + d, 1.0, st); }), tolerance);
        EXPECT_NEAR(s.d_sigma_radial, difference([&](double d) { return value(r, a, 1.0 + d, st); }),
                    tolerance);
        EXPECT_NEAR(s.d_sigma_tangential, difference([&](double d) { return value(r, a, 1.0, st + d); }),
                    tolerance);
      }
}

TEST(GaussianInDisc, IsZeroFarOutsideAndOneFarInside) {
  EXPECT_EQ(gaussian_in_disc(1.0, 100.0, 1.0, 1.0, rules()).value, 0.0);
  EXPECT_EQ(gaussian_in_disc(100.0, 1.0, 1.0, 1.0, rules()).value, 1.0);
  EXPECT_EQ(gaussian_in_disc(0.0, 0.0, 1.0, 1.0, rules()).value, 0.0);
}
