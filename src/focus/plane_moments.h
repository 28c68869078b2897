#pragma once
#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

struct Point {
  double x = 0, y = 0;
};

/// Weighted sum of squared distances from `centre` at plane dz [m^2], and `scale` times half its gradient,
/// dense.
double second_moment(const RayBundle& rays, double dz, Point centre);
void second_moment_gradient(const RayBundle& rays, double dz, Point centre, double scale,
                            RayGradient* gradient);

struct HeightMoments {
  double mean, rms;
};
HeightMoments height_moments(const Eigen::ArrayXd& weight, const Eigen::ArrayXd& height);

}  // namespace aberfit::internal
