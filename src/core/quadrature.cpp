#include "aberfit/core/quadrature.h"

#include <boost/math/special_functions/legendre.hpp>

namespace aberfit {

Quadrature gauss_legendre(int n, double a, double b) {
  const std::vector<double> zeros =
      boost::math::legendre_p_zeros<double>(n);  // the non-negative half, ascending
  Quadrature rule{Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  const double centre = 0.5 * (a + b), half = 0.5 * (b - a);
  for (std::size_t i = 0; i < zeros.size(); ++i) {
    const double x = zeros[i], derivative = boost::math::legendre_p_prime(n, x);
    const double weight = half * 2.0 / ((1.0 - x * x) * derivative * derivative);
    const Eigen::Index upper = n / 2 + Eigen::Index(i), lower = n - 1 - upper;
    rule.nodes[upper] = centre + half * x;
    rule.nodes[lower] = centre - half * x;
    rule.weights[upper] = rule.weights[lower] = weight;
  }
  return rule;
}

Eigen::ArrayXXd legendre_polynomials(const Eigen::ArrayXd& t, int count) {
  Eigen::ArrayXXd p = Eigen::ArrayXXd::Ones(t.size(), count);
  if (count > 1) p.col(1) = t;
  for (int l = 1; l + 1 < count; ++l)
    p.col(l + 1) = ((2 * l + 1) * t * p.col(l) - l * p.col(l - 1)) / (l + 1.0);
  return p;
}

LegendreRule legendre_rule(int n) {
  const Quadrature rule = gauss_legendre(n, -1.0, 1.0);
  return {rule.nodes, rule.weights, legendre_polynomials(rule.nodes, n)};
}

}  // namespace aberfit
