#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

#include "aberfit/spectrum/detrend.h"

namespace aberfit::internal {

/// Legendre polynomials P_0 .. P_degree at the points x mapped from [low, high] to [-1, 1]: N x (degree + 1).
Eigen::MatrixXd legendre_basis(const Eigen::ArrayXd& x, double low, double high, int degree);

/// Degrees of the products P_i(x) P_j(y) up to a total degree, which ascends; of one total i descends.
std::vector<std::pair<int, int>> products_up_to(int degree);

/// Polynomial degree that `options` takes off heights, -1 for none. Noll modes up to radial order n span the
/// polynomials of degree n, so that least squares over the same points gives the same shape; an ellipse moves
/// heights by polynomials of degree 4 (five parameters) on a profile, a quadric on a map.
int polynomial_degree(const DetrendOptions& options, bool profile);

/// Mirror ellipse fitted to a profile.
struct EllipseFit {
  bool converged = false;
  double p = 0, q = 0, grazing_angle = 0;  ///< [m], [m], [rad]; pole in the middle of the profile
  Eigen::ArrayXd shape;                    ///< in the profile's own quantity, at every x
};
EllipseFit fit_ellipse(const Profile& profile);

}  // namespace aberfit::internal
