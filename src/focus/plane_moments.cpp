#include "plane_moments.h"

#include <cmath>

#include "ray_blocks.h"

namespace aberfit::internal {

double weight_inside(const RayBundle& rays, double dz, Point centre, double radius) {
  const auto x = rays.x + dz * rays.tx - centre.x, y = rays.y + dz * rays.ty - centre.y;
  return (x.square() + y.square() <= radius * radius).select(rays.weight, 0.0).sum();
}

double smooth_weight_inside(const RayBundle& rays, double dz, Point centre, const SmoothDisc& disc) {
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  double sums[3] = {};
  for_each_block(rays, 0, rays.size(), [&](const RayBlock& block, Eigen::Index, int) {
    kernels.share(block, dz, {centre.x, centre.y, disc.radius2, disc.scale}, sums);
  });
  return sums[0];
}

void smooth_share_gradient(const RayBundle& rays, double dz, Point centre, const SmoothDisc& disc,
                           double scale, RayGradient* gradient) {
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  gradient->dz = dz;
  alignas(64) double density[kBlockRays];
  for_each_block(rays, 0, rays.size(), [&](const RayBlock& block, Eigen::Index first, int used) {
    kernels.share_density(block, dz, {centre.x, centre.y, disc.radius2, disc.scale}, density);
    for (int i = 0; i < used; ++i) {
      if (!(density[i] > 0.0)) continue;
      const double share = -2 * scale * density[i];
      gradient->rays.push_back(std::uint32_t(first + i));
      gradient->d_x.push_back(share * (block.x[i] + dz * block.tx[i] - centre.x));
      gradient->d_y.push_back(share * (block.y[i] + dz * block.ty[i] - centre.y));
    }
  });
}

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
