// Even polynomials of the radius against the functions that they replace.
#include "../../src/theory/even_polynomial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "../../src/theory/pupil_field.h"

namespace aberfit::internal {
namespace {

constexpr double kRadius = 0.7;

double largest_error(const EvenPolynomial& polynomial, const std::function<double(double)>& truth) {
  constexpr int kPoints = 1001;  // not a multiple of the kernel's vector length
  std::vector<double> x(kPoints), y(kPoints), value(kPoints);
  for (int k = 0; k < kPoints; ++k) {
    const double rho = kRadius * k / (kPoints - 1), angle = 2.4 * k;
    x[std::size_t(k)] = rho * std::cos(angle);
    y[std::size_t(k)] = rho * std::sin(angle);
  }
  double worst = 0;
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    std::fill(value.begin(), value.end(), 1.0);  // the values to which the polynomial is added
    polynomial.add(x.data(), y.data(), kPoints, value.data(), set);
    for (int k = 0; k < kPoints; ++k)
      worst = std::max(worst, std::abs(value[std::size_t(k)] - 1 - truth(kRadius * k / (kPoints - 1))));
  }
  return worst;
}

TEST(EvenPolynomial, HoldsEvenPowersToRounding) {
  const auto powers = [](double rho) { return 40 * std::pow(rho, 4) - 7 * std::pow(rho, 12) + 3; };
  const std::optional<EvenPolynomial> found = EvenPolynomial::of(powers, kRadius, 1e-9);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->degree(), 6);
  EXPECT_LT(largest_error(*found, powers), 1e-12);
}

TEST(EvenPolynomial, KeepsItsPromiseOrIsNone) {
  const auto bell = [](double width) {
    return [width](double rho) { return std::exp(-rho * rho / (width * width)); };
  };
  for (const double width : {1.0, 0.4, 0.25}) {
    const std::optional<EvenPolynomial> found = EvenPolynomial::of(bell(width), kRadius, 1e-9);
    ASSERT_TRUE(found) << width;
    EXPECT_LT(largest_error(*found, bell(width)), 2e-9) << width;
  }
  EXPECT_FALSE(EvenPolynomial::of(bell(0.05), kRadius, 1e-9));                      // too narrow
  EXPECT_FALSE(EvenPolynomial::of([](double rho) { return rho; }, kRadius, 1e-9));  // not even
  EXPECT_FALSE(EvenPolynomial::of([](double) { return std::nan(""); }, kRadius, 1e-9));
}

// The field of a sphere uses the polynomial: phases of two points by hand, in focus and out of it.
TEST(EvenPolynomial, StandsForASphereInThePupil) {
  constexpr double kFocal = 2.5, kWave = 500e-9, kDz = 3e-4;
  const Mirror sphere{kFocal, 0, {}};
  const PupilField field(sphere, CircleAperture{2 * kRadius}, kWave, {});
  ASSERT_TRUE(field.is_round());
  const double x1[] = {0.3}, y1[] = {-0.2}, x2[] = {0.05}, y2[] = {0.55};
  double amplitude, difference, scratch;
  field.pairs(kDz, x1, y1, x2, y2, 1, &amplitude, &difference, &scratch);
  const auto phase = [&](double x, double y) {
    const double p = std::hypot(x, y) / kFocal, c = std::sqrt(1 - p * p), rho = 2 * kFocal * p / (1 + c);
    const double radius = 2 * kFocal, sag = rho * rho / (radius + std::sqrt(radius * radius - rho * rho));
    return 2 * std::numbers::pi / kWave *
           ((1 + c) * (sag - rho * rho / (4 * kFocal)) + kDz * (1 - c) / (1 + kDz / kFocal));
  };
  const double truth = phase(x1[0], y1[0]) - phase(x2[0], y2[0]);
  EXPECT_GT(std::abs(truth), 100);  // rad
  EXPECT_NEAR(difference, truth, 1e-8);
}

}  // namespace
}  // namespace aberfit::internal
