#pragma once
#include <vector>

#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

/// Weighted sums over the rays of the angle [rad] between each ray and its nominal ray, and of its square.
/// The angles come from cross and dot product, so small angles lose no digits.
struct AngleSums {
  double squares = 0, firsts = 0;
};
AngleSums sum_angles(const RayBundle& rays, const RayBundle& nominal, int threads);

/// d_tx, d_ty of every ray: `scale` times the gradient of the weighted sum of angle^2 / 2, or of the angles
/// when `mean`. The gradient of the angles is 0 for a zero angle, where it does not exist.
void angle_gradient(const RayBundle& rays, const RayBundle& nominal, double scale, bool mean, int threads,
                    std::vector<double>* d_tx, std::vector<double>* d_ty);

}  // namespace aberfit::internal
