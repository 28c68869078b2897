#include "aberfit/core/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace aberfit;

TEST(GaussLegendre, IsExactForPolynomialsUpToTwiceItsPoints) {
  for (const int n : {1, 2, 5, 16, 64, 257}) {
    const Quadrature rule = gauss_legendre(n, 0.5, 2.0);
    EXPECT_TRUE((rule.nodes.tail(n - 1) > rule.nodes.head(n - 1)).all());
    for (int degree = 0; degree < std::min(2 * n, 40); ++degree) {
      const double exact = (std::pow(2.0, degree + 1) - std::pow(0.5, degree + 1)) / (degree + 1);
      const double sum = (rule.weights * rule.nodes.pow(double(degree))).sum();
      EXPECT_NEAR(sum / exact, 1.0, 4e-15 * n) << n << " points, degree " << degree;
    }
  }
}
