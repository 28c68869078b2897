#include "aberfit/focus/counted_ring_width.h"

#include <algorithm>
#include <vector>

namespace aberfit {

double counted_ring_width(const RayBundle& rays, double ring_radius, double pitch, double reach) {
  const int steps = int(reach / pitch);
  std::vector<double> share;
  for (int k = -steps; k <= steps; ++k) {
    const double dz = k * pitch;
    const Eigen::ArrayXd x = rays.x + dz * rays.tx, y = rays.y + dz * rays.ty;
    share.push_back((x.square() + y.square() <= ring_radius * ring_radius).select(rays.weight, 0.0).sum());
  }
  const double half = 0.5 * *std::max_element(share.begin(), share.end());
  return pitch * double(std::count_if(share.begin(), share.end(), [half](double n) { return n >= half; }));
}

}  // namespace aberfit
