#include "plane_moments.h"

#include <cmath>

namespace aberfit::internal {

double second_moment(const RayBundle& rays, double dz, Point centre) {
  return (rays.weight *
          ((rays.x + dz * rays.tx - centre.x).square() + (rays.y + dz * rays.ty - centre.y).square()))
      .sum();
}

void second_moment_gradient(const RayBundle& rays, double dz, Point centre, double scale,
                            RayGradient* gradient) {
  gradient->dz = dz;
  gradient->all_rays = true;
  gradient->d_x.resize(std::size_t(rays.size()));
  gradient->d_y.resize(std::size_t(rays.size()));
  Eigen::Map<Eigen::ArrayXd>(gradient->d_x.data(), rays.size()) =
      scale * rays.weight * (rays.x + dz * rays.tx - centre.x);
  Eigen::Map<Eigen::ArrayXd>(gradient->d_y.data(), rays.size()) =
      scale * rays.weight * (rays.y + dz * rays.ty - centre.y);
}

HeightMoments height_moments(const Eigen::ArrayXd& weight, const Eigen::ArrayXd& height) {
  const double total = weight.sum(), mean = (weight * height).sum() / total;
  return {mean, std::sqrt((weight * (height - mean).square()).sum() / total)};
}

}  // namespace aberfit::internal
