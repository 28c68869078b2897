#pragma once
#include <Eigen/Core>

#include "aberfit/terms/term_set.h"

namespace aberfit {

/// d2h/dxdy [1/m] of a term surface at points x, y [m]. Zernike part: the gradient of an expansion is an
/// expansion again (Noll 1976, eq. 13-14 in spirit: gradients are finite sums of lower modes), so one linear
/// map of coefficients and one gradient evaluation give it without new kernels; spherical terms and waves
/// have closed forms. x, y and the terms as in SurfaceOperator, errors alike. Error below 1e-11 of the
/// largest value for n <= 60.
Eigen::ArrayXd cross_derivative(const TermSet& terms, const Eigen::VectorXd& coefficients,
                                const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

}  // namespace aberfit
