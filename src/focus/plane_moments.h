#pragma once
#include "aberfit/trace/ray_bundle.h"
#include "kernel.h"

namespace aberfit::internal {

struct Point {
  double x = 0, y = 0;
};

/// Weight of the rays within `radius` of `centre` at plane dz.
double weight_inside(const RayBundle& rays, double dz, Point centre, double radius);
/// The same with the smooth disc for the indicator, and `scale` times its gradient at fixed disc.
double smooth_weight_inside(const RayBundle& rays, double dz, Point centre, const SmoothDisc& disc);
void smooth_share_gradient(const RayBundle& rays, double dz, Point centre, const SmoothDisc& disc,
                           double scale, RayGradient* gradient);

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
