#pragma once
#include <Eigen/Core>
#include <vector>

namespace aberfit::internal {

/// Chebyshev's polynomials in two numbers of [0, 1], up to `order` of them in each, and the nodes at which
/// functions are interpolated by them.
struct MomentBasis {
  explicit MomentBasis(int order);
  int order;
  std::vector<double> nodes;  ///< ascending
  Eigen::MatrixXd lagrange;   ///< (i, p): of the polynomial p in the Lagrange polynomial of node i
  /// Moments of the Lagrange polynomials, i major, from those of Chebyshev's (p, q).
  Eigen::ArrayXd at_nodes(const Eigen::MatrixXd& by_chebyshev) const;
};

}  // namespace aberfit::internal
