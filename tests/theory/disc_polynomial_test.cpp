// Polynomials over a disc against the functions they stand for.
#include "../../src/theory/disc_polynomial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

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
    EXPECT_EQ(found->degree(), mode.n + mode.n % 2);
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

}  // namespace
}  // namespace aberfit::internal
