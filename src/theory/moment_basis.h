#pragma once
#include <Eigen/Core>
#include <vector>

namespace aberfit::internal {

/// Chebyshev polynomials in two numbers of [0, 1], `order` in each, and their interpolation nodes.
struct MomentBasis {
  explicit MomentBasis(int order);
  int order;
  std::vector<double> nodes;  ///< ascending
  Eigen::MatrixXd lagrange;   ///< (i, p): part of polynomial p in the Lagrange polynomial of node i
  /// Moments of the Lagrange polynomials, i major, from those of the Chebyshev polynomials (p, q).
  Eigen::ArrayXd at_nodes(const Eigen::MatrixXd& by_chebyshev) const;
};

}  // namespace aberfit::internal
