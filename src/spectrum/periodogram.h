#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/spectrum/ordinate_bins.h"

namespace aberfit::internal {

/// Hermitian covariance of the lowest ordinates for a red surface, where detrending makes neighbours depend
/// on each other in a way the window alone does not tell.
struct LowOrdinates {
  std::vector<int> index;  ///< places in the grid, closed under conjugation
  Eigen::MatrixXcd covariance;
};

/// cov(mean_b, mean_c)/(E_b E_c) of Gaussian surfaces from |W2(k - l)|^2 + |W2(k + l)|^2, summed over all
/// pairs of ordinates (Percival and Walden 1993, eq. 222); `low` takes precedence where both ordinates belong
/// to it.
Eigen::MatrixXd bin_covariance(const OrdinateGrid& grid, const OrdinateBins& bins,
                               const Eigen::ArrayXd& along_x, const Eigen::ArrayXd& along_y,
                               const LowOrdinates& low);

}  // namespace aberfit::internal
