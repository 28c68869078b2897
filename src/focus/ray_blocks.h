#pragma once
#include <algorithm>
#include <vector>

#include "aberfit/trace/ray_bundle.h"
#include "focus_kernel.h"

namespace aberfit::internal {

/// Calls visit(block, first, used) for the rays [begin, end) in blocks for the kernels, with `used` rays from
/// ray `first` on. A remainder that does not fill a vector is a copy, padded with weight 0.
template <typename Visit>
void for_each_block(const RayBundle& rays, Eigen::Index begin, Eigen::Index end, const Visit& visit) {
  const double* const from[5] = {rays.x.data(), rays.y.data(), rays.tx.data(), rays.ty.data(),
                                 rays.weight.data()};
  while (begin < end) {
    const int left = int(std::min<Eigen::Index>(kBlockRays, end - begin));
    const int whole = left - left % kRayPadding;
    if (whole > 0) {
      visit(RayBlock{from[0] + begin, from[1] + begin, from[2] + begin, from[3] + begin, from[4] + begin,
                     whole},
            begin, whole);
      begin += whole;
    } else {
      double padded[5][kRayPadding] = {};
      for (int a = 0; a < 5; ++a) std::copy_n(from[a] + begin, left, padded[a]);
      visit(RayBlock{padded[0], padded[1], padded[2], padded[3], padded[4], kRayPadding}, begin, left);
      begin += left;
    }
  }
}

/// Groups of rays whose sums are added in order. They depend only on the number of rays, not on threads.
struct RayGroups {
  Eigen::Index rays;
  int count;
  explicit RayGroups(Eigen::Index n, int most = 16)
      : rays(n), count(int(std::clamp<Eigen::Index>((n + 8192) / 16384, 1, most))) {}
  Eigen::Index begin(int g) const { return g == count ? rays : rays * g / count / kBlockRays * kBlockRays; }
};

/// Gives `v` at least `needed` entries. Extra room avoids new memory when a little more is needed later.
template <typename T>
void make_room(std::vector<T>& v, std::size_t needed) {
  if (v.size() < needed) v.resize(needed + needed / 2 + 64);
}

/// Resizes `v`. A new allocation has an eighth to spare, as the next evaluation may need a few more.
template <typename T>
void resize_with_spare(std::vector<T>& v, std::size_t size) {
  if (v.capacity() < size) v.reserve(size + size / 8 + 64);
  v.resize(size);
}

/// Sums over all rays.
RaySums sum_rays(const RayBundle& rays, int threads);

}  // namespace aberfit::internal
