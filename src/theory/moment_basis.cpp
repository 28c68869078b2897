#include "moment_basis.h"

#include <cmath>
#include <numbers>

namespace aberfit::internal {

MomentBasis::MomentBasis(int count) : order(count), lagrange(count, count) {
  using std::numbers::pi;
  for (int i = 0; i < order; ++i) nodes.push_back(0.5 - 0.5 * std::cos(pi * (i + 0.5) / order));
  for (int i = 0; i < order; ++i)
    for (int p = 0; p < order; ++p)
      lagrange(i, p) = (p == 0 ? 1.0 : 2.0) / order * std::cos(p * (pi - pi * (i + 0.5) / order));
}

Eigen::ArrayXd MomentBasis::at_nodes(const Eigen::MatrixXd& by_chebyshev) const {
  const Eigen::MatrixXd all = lagrange * by_chebyshev * lagrange.transpose();
  return all.transpose().reshaped().array();
}

}  // namespace aberfit::internal
