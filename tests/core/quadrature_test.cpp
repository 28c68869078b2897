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

TEST(LegendrePolynomials, AreTheClosedFormsAndOrthogonalUnderTheirRule) {
  constexpr int kCount = 24;
  const LegendreRule rule = legendre_rule(kCount);
  const Eigen::ArrayXd t = rule.nodes;
  const Eigen::ArrayXXd& p = rule.polynomials;
  EXPECT_LT((p.col(2) - (1.5 * t.square() - 0.5)).abs().maxCoeff(), 1e-15);
  EXPECT_LT((p.col(3) - (2.5 * t.cube() - 1.5 * t)).abs().maxCoeff(), 1e-15);
  // int P_l P_m = 2/(2l+1) if l = m, else 0. The rule integrates degree 2 kCount - 2 exactly.
  const Eigen::MatrixXd gram = p.matrix().transpose() * rule.weights.matrix().asDiagonal() * p.matrix();
  for (int l = 0; l < kCount; ++l)
    for (int m = 0; m < kCount; ++m) EXPECT_NEAR(gram(l, m), l == m ? 2.0 / (2 * l + 1) : 0, 1e-14);
  const Eigen::ArrayXXd ends = legendre_polynomials(Eigen::Array2d(-1, 1), kCount);
  for (int l = 0; l < kCount; ++l) {
    EXPECT_EQ(ends(0, l), l % 2 == 0 ? 1 : -1);
    EXPECT_EQ(ends(1, l), 1);
  }
  EXPECT_EQ(legendre_polynomials(t, 1).cols(), 1);
}
