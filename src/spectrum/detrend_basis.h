#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

#include "aberfit/spectrum/detrend.h"

namespace aberfit::internal {

/// Legendre polynomials P_0 .. P_degree at the points x mapped from [low, high] to [-1, 1]: N x (degree + 1).
Eigen::MatrixXd legendre_basis(const Eigen::ArrayXd& x, double low, double high, int degree);

/// Returns the degrees (i, j) of the products P_i(x) P_j(y), ascending in total degree, then descending in i.
std::vector<std::pair<int, int>> products_up_to(int degree);

/// Returns the degree of the polynomial that `options` subtracts from heights, -1 for none. Noll modes up to
/// radial order n span the polynomials of degree n. An ellipse changes heights of a profile by polynomials of
/// degree 4 (five parameters), a quadric those of a map by degree 2.
int polynomial_degree(const DetrendOptions& options, bool profile);

/// Mirror ellipse fitted to a profile.
struct EllipseFit {
  bool converged = false;
  double p = 0, q = 0, grazing_angle = 0;  ///< [m], [m], [rad]; the pole is in the middle of the profile
  Eigen::ArrayXd shape;                    ///< in the quantity of the profile, at every x
};
EllipseFit fit_ellipse(const Profile& profile);

}  // namespace aberfit::internal
