#pragma once
#include <Eigen/Core>

#include "aberfit/terms/term_set.h"

namespace aberfit {

/// d2h/dxdy [1/m] of a term surface at points x, y [m]. x, y, terms and errors are as in SurfaceOperator. The
/// gradient of a Zernike expansion is an expansion again (after Noll 1976, eq. 13-14). So one linear map of
/// coefficients and one gradient evaluation give the Zernike part. Spherical terms and waves have closed
/// forms. The error is below 1e-11 of the largest value for n <= 60.
Eigen::ArrayXd cross_derivative(const TermSet& terms, const Eigen::VectorXd& coefficients,
                                const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

}  // namespace aberfit
