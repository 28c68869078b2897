#pragma once
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

/// Angle [rad] between each ray and its nominal ray, from cross and dot product (no loss of digits at small
/// angles).
Eigen::ArrayXd scatter_angles(const RayBundle& rays, const RayBundle& nominal);

/// Gradient of sum_i weights[i] angle_i^2 / 2 over tx and ty of every ray (finite where the angle vanishes).
void squared_angle_gradient(const RayBundle& rays, const RayBundle& nominal, const Eigen::ArrayXd& weights,
                            Eigen::ArrayXd* d_tx, Eigen::ArrayXd* d_ty);

}  // namespace aberfit
