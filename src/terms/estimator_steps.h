#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

// The linear steps of the PSD estimator of maps (psd_estimate.h) on a full square grid, apart, so that they
// can be run backwards. A test holds them to the estimator itself.

/// Window at (i + 1/2)/n.
Eigen::ArrayXd estimator_window(WindowKind window, int n);
/// Total degree of the polynomial that detrending takes off a map; -1: nothing.
int detrend_degree(const DetrendOptions& options);
/// Polynomials of degree 0 .. degree, orthonormal on n equidistant points: n x (degree + 1).
Eigen::MatrixXd orthonormal_polynomials(int n, int degree);

struct EstimatorBins {
  std::vector<int> of;       ///< bin of every ordinate of the n x n transform; -1: none
  Eigen::ArrayXd low, high;  ///< [cycles/m]
  Eigen::ArrayXd members;    ///< ordinates of the transform, both of a conjugate pair
};
/// Logarithmic bins, bins_per_decade of them, the lowest ordinate in the middle of the first, up to the
/// Nyquist frequency of an axis; steps without any ordinate are shared by their neighbours.
EstimatorBins estimator_bins(int n, double pitch, int bins_per_decade);

}  // namespace aberfit::internal
