#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// A sum of orthonormal Zernike modes on the unit disc.
struct ZernikeExpansion {
  std::vector<ZernikeMode> modes;
  Eigen::VectorXd coefficients;
};

/// Derivative of an expansion along y of the disc, as an expansion in all modes of lower order (OSA order).
/// With V_n^m = R_n^|m| exp(i m theta)
///   dV/dy = i sum_l (n - 2l) (V_{n-1-2l}^{m-1} - V_{n-1-2l}^{m+1})
/// (Noll 1976, eq. 14, in the form of Janssen 2014). The factor depends only on the lower order, so running
/// sums over n make the cost linear in the number of modes. Exact except for rounding.
ZernikeExpansion zernike_derivative_along_y(const ZernikeExpansion& expansion);

}  // namespace aberfit::internal
