// Polynomials over a disc against the functions they stand for.
#include "../../src/theory/disc_polynomial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "../../src/theory/pupil_field.h"
#include "aberfit/scene/zernike.h"

namespace aberfit::internal {
namespace {

constexpr double kRadius = 0.3;

// Largest error over a disc, on a grid that has nothing to do with the fit's rings.
double largest_error(const DiscPolynomial& polynomial, const std::function<double(double, double)>& truth,
                     InstructionSet set = best_instruction_set()) {
  std::vector<double> x, y;
  for (int i = -41; i <= 41; ++i)
    for (int j = -41; j <= 41; ++j)
      if (std::hypot(i, j) <= 41) x.push_back(kRadius * i / 41), y.push_back(kRadius * j / 41);
  std::vector<double> value(x.size(), 1.0);  // what it adds to
  polynomial.add(x.data(), y.data(), int(x.size()), value.data(), set);
  double worst = 0;
  for (std::size_t k = 0; k < x.size(); ++k)
    worst = std::max(worst, std::abs(value[k] - 1 - truth(x[k], y[k])));
  return worst;
}

TEST(DiscPolynomial, HoldsZernikesOfItsDegreeToRounding) {
  for (const ZernikeMode mode :
       {ZernikeMode{2, -2}, ZernikeMode{3, 3}, ZernikeMode{8, -4}, ZernikeMode{16, 10}}) {
    const auto height = [&](double x, double y) {
      return 100 * zernike(mode, x / kRadius, y / kRadius).value;
    };
    const std::optional<DiscPolynomial> found = DiscPolynomial::of(height, kRadius, 1e-6);
    ASSERT_TRUE(found) << mode.n;
    EXPECT_EQ(found->degree(), std::max(4, mode.n + mode.n % 2));
    // By the instruction sets of this processor: (1 + sqrt 2)^16 roundings at most.
    for (const InstructionSet set : {InstructionSet::kBaseline, best_instruction_set()})
      EXPECT_LT(largest_error(*found, height, set), 1e-8) << mode.n;
  }
}

TEST(DiscPolynomial, KeepsItsPromiseBetweenItsPointsOrIsNone) {
  // A wave of w rad across the radius: powers up to 16 hold few of them.
  const auto wave = [](double w) {
    return [w](double x, double y) { return std::cos(w * (0.8 * x - 0.6 * y) / kRadius); };
  };
  for (const double w : {0.5, 2.0, 4.0}) {
    const std::optional<DiscPolynomial> found = DiscPolynomial::of(wave(w), kRadius, 1e-6);
    ASSERT_TRUE(found) << w;
    EXPECT_LT(largest_error(*found, wave(w)), 1.2e-6) << w;
    EXPECT_LE(found->degree(), w < 1 ? 8 : 16);
  }
  EXPECT_FALSE(DiscPolynomial::of(wave(12), kRadius, 1e-6));
  EXPECT_FALSE(DiscPolynomial::of([](double x, double y) { return std::hypot(x, y); }, kRadius, 1e-6));
  EXPECT_FALSE(
      DiscPolynomial::of([](double x, double) { return x < 0.1 ? 0 : std::nan(""); }, kRadius, 1e-6));
}

// Pairs of points of a pupil with known aberrations, whose phase is a polynomial (astigmatism, coma) or comes
// from a table (radial order 20, which powers up to 16 do not hold), against the formula written anew.
TEST(PupilField, PairsHaveThePhaseAndAmplitudeOfTheFormula) {
  constexpr double kFocal = 0.9, kWavelength = 5e-7, kDz = 2e-3;
  struct Case {
    ZernikeMode mode;
    double height, error;  // [m], [rad]
  };
  for (const Case& c : {Case{{2, 2}, 4e-7, 2e-6}, Case{{3, -1}, 2e-7, 2e-6}, Case{{20, 4}, 2e-9, 5e-4}}) {
    const auto height = [&](double x, double y) {
      return c.height * zernike(c.mode, x / kRadius, y / kRadius).value;
    };
    const PupilField field({.focal_length = kFocal}, CircleAperture{2 * kRadius, 0}, kWavelength, height);
    const double wave = 2 * std::numbers::pi / kWavelength;
    const auto cosine = [&](double x, double y) {
      return std::sqrt(1 - (x * x + y * y) / (kFocal * kFocal));
    };
    const auto phase = [&](double x, double y) {
      const double one_plus = 1 + cosine(x, y), scale = 2 / one_plus;  // r over P
      return wave * (one_plus * height(scale * x, scale * y) + kDz * (2 - one_plus) / (1 + kDz / kFocal));
    };
    const auto amplitude = [&](double x, double y) {
      return 2 / ((1 + cosine(x, y)) * std::sqrt(cosine(x, y)));
    };
    const std::vector<double> x1{0.01, -0.2, 0.13, 0.25, -0.07}, y1{0.02, 0.11, -0.2, 0.05, -0.26},
        x2{-0.15, 0.05, 0.22, -0.1, 0.2}, y2{0.2, -0.06, 0.12, -0.22, 0.01};
    std::vector<double> product(5), difference(5), scratch(5);
    field.pairs(kDz, x1.data(), y1.data(), x2.data(), y2.data(), 5, product.data(), difference.data(),
                scratch.data());
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_NEAR(product[k], amplitude(x1[k], y1[k]) * amplitude(x2[k], y2[k]), 1e-14);
      EXPECT_NEAR(difference[k], phase(x1[k], y1[k]) - phase(x2[k], y2[k]), c.error) << c.mode.n;
    }
  }
}

}  // namespace
}  // namespace aberfit::internal
