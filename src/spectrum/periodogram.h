#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/spectrum/ordinate_bins.h"

namespace aberfit::internal {

/// Hermitian covariance of the lowest ordinates for a red surface, including the effect of detrending.
struct LowOrdinates {
  std::vector<int> index;  ///< indices in the grid, closed under conjugation
  Eigen::MatrixXcd covariance;
};

/// Returns cov(mean_b, mean_c)/(E_b E_c) of Gaussian surfaces: |W2(k - l)|^2 + |W2(k + l)|^2 over all pairs
/// of ordinates (Percival and Walden 1993, eq. 222); `low` replaces it where both ordinates belong to it.
Eigen::MatrixXd bin_covariance(const OrdinateGrid& grid, const OrdinateBins& bins,
                               const Eigen::ArrayXd& along_x, const Eigen::ArrayXd& along_y,
                               const LowOrdinates& low);

}  // namespace aberfit::internal
