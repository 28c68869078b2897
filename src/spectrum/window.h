#pragma once
#include <Eigen/Core>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// Returns the half width of the main lobe [ordinates]. The power of a sine further away is called leakage.
int main_lobe(WindowKind window);
/// Returns |W(nu)|^2 = |sum w_i exp(-2 pi i nu (i + 1/2)/n)|^2 / (n sum w^2), the power in ordinate k from a
/// unit wave at k + nu. It sums to 1 over the ordinates.
double lobe(const Eigen::ArrayXd& window, double nu);
/// Returns |W2(d)|^2 at whole d = 0 .. 8, the relative covariance of ordinates d apart (Hann: 1, 4/9, 1/36).
/// W2 is the transform of the squared window with W2(0) = 1. Values below 1e-4 are set to 0.
Eigen::ArrayXd ordinate_covariance(const Eigen::ArrayXd& window);

}  // namespace aberfit::internal
