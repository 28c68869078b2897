#pragma once
#include <Eigen/Core>

#include "aberfit/roughness/psd.h"

namespace aberfit::internal {

/// Covariances [m^2] of the coefficients of all radial orders n_min..n_max; (n, n') is at (n - n_min, n' -
/// n_min). The sign (-1)^((n+n'-2|m|)/2) = (-1)^((n-n')/2) does not depend on m, so an entry holds for every
/// signed m of both orders. Orders of different parity have no common m and give 0. Throws ComputationError
/// when the integral diverges.
Eigen::MatrixXd zernike_covariance_table(const RadialPsd& psd, double radius, int n_min, int n_max);

/// Its diagonal only, in time linear in n_max per quadrature node.
Eigen::ArrayXd zernike_variances(const RadialPsd& psd, double radius, int n_min, int n_max);

}  // namespace aberfit::internal
