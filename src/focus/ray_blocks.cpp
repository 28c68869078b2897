#include "ray_blocks.h"

#include "aberfit/core/parallel.h"

namespace aberfit::internal {

RaySums sum_rays(const RayBundle& rays, int threads) {
  const RayGroups groups(rays.size());
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  std::vector<RaySums> parts(std::size_t(groups.count));
  parallel_for(parts.size(), threads, [&](std::size_t g) {
    RaySums part;
    for_each_block(rays, groups.begin(int(g)), groups.begin(int(g) + 1),
                   [&](const RayBlock& block, Eigen::Index, int) { kernels.sums(block, &part); });
    parts[g] = part;
  });
  RaySums total;
  for (const RaySums& part : parts) {
    total.weight += part.weight;
    total.x += part.x;
    total.y += part.y;
    total.tx += part.tx;
    total.ty += part.ty;
    total.slope2 += part.slope2;
  }
  return total;
}

}  // namespace aberfit::internal
