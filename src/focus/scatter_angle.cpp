#include "scatter_angle.h"

#include <cmath>

#include "aberfit/core/parallel.h"
#include "ray_blocks.h"

namespace aberfit::internal {
namespace {

// Cross product of (tx, ty, 1) and (vx, vy, 1), its length, and the dot product.
struct Pair {
  double cx, cy, cz, cross, dot;
  Pair(double tx, double ty, double vx, double vy)
      : cx(ty - vy), cy(vx - tx), cz((tx - vx) * vy - (ty - vy) * vx) {
    cross = std::sqrt(cx * cx + cy * cy + cz * cz);
    dot = tx * vx + ty * vy + 1.0;
  }
};

// Nominal directions of a block, with the same padding.
class NominalBlock {
 public:
  NominalBlock(const RayBundle& nominal, Eigen::Index first, int used, int count)
      : tx_(nominal.tx.data() + first), ty_(nominal.ty.data() + first) {
    if (used == count) return;
    std::copy_n(tx_, used, padded_[0]);
    std::copy_n(ty_, used, padded_[1]);
    tx_ = padded_[0];
    ty_ = padded_[1];
  }
  NominalBlock(const NominalBlock&) = delete;
  NominalBlock& operator=(const NominalBlock&) = delete;
  const double* tx() const { return tx_; }
  const double* ty() const { return ty_; }

 private:
  const double *tx_, *ty_;
  double padded_[2][kRayPadding] = {};
};

// Slower functions for blocks with angles outside the range of the kernels' series.
void add_angles(const RayBlock& rays, const NominalBlock& nominal, double* sums) {
  for (int i = 0; i < rays.count; ++i) {
    const Pair pair(rays.tx[i], rays.ty[i], nominal.tx()[i], nominal.ty()[i]);
    const double angle = std::atan2(pair.cross, pair.dot);
    sums[0] += rays.weight[i] * angle * angle;
    sums[1] += rays.weight[i] * angle;
  }
}
void gradient_of_angles(const RayBlock& rays, const NominalBlock& nominal, double scale, bool mean,
                        double* d_tx, double* d_ty) {
  for (int i = 0; i < rays.count; ++i) {
    const double vx = nominal.tx()[i], vy = nominal.ty()[i];
    const Pair pair(rays.tx[i], rays.ty[i], vx, vy);
    // For angle = atan2(cross, dot), d(angle^2/2) = angle/cross (dot cross dcross - cross^2 ddot)/(cross^2 +
    // dot^2).
    const double cross2 = pair.cross * pair.cross;
    double unit = scale * rays.weight[i] / (cross2 + pair.dot * pair.dot);
    if (mean)
      unit = pair.cross > 0 ? unit / pair.cross : 0.0;
    else
      unit *= pair.cross > 0 ? std::atan2(pair.cross, pair.dot) / pair.cross : 1.0 / pair.dot;
    d_tx[i] = unit * (pair.dot * (-pair.cy + pair.cz * vy) - cross2 * vx);
    d_ty[i] = unit * (pair.dot * (pair.cx - pair.cz * vx) - cross2 * vy);
  }
}

}  // namespace

AngleSums sum_angles(const RayBundle& rays, const RayBundle& nominal, int threads) {
  const RayGroups groups(rays.size());
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  std::vector<AngleSums> parts(std::size_t(groups.count));
  parallel_for(parts.size(), threads, [&](std::size_t g) {
    AngleSums part;
    for_each_block(rays, groups.begin(int(g)), groups.begin(int(g) + 1),
                   [&](const RayBlock& block, Eigen::Index first, int used) {
                     const NominalBlock reference(nominal, first, used, block.count);
                     double sums[2] = {};
                     if (!kernels.angles(block, reference.tx(), reference.ty(), sums)) {
                       sums[0] = sums[1] = 0;
                       add_angles(block, reference, sums);
                     }
                     part.squares += sums[0];
                     part.firsts += sums[1];
                   });
    parts[g] = part;
  });
  AngleSums total;
  for (const AngleSums& part : parts) {
    total.squares += part.squares;
    total.firsts += part.firsts;
  }
  return total;
}

void angle_gradient(const RayBundle& rays, const RayBundle& nominal, double scale, bool mean, int threads,
                    std::vector<double>* d_tx, std::vector<double>* d_ty) {
  d_tx->resize(std::size_t(rays.size()));
  d_ty->resize(std::size_t(rays.size()));
  const RayGroups groups(rays.size());
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  parallel_for(std::size_t(groups.count), threads, [&](std::size_t g) {
    for_each_block(
        rays, groups.begin(int(g)), groups.begin(int(g) + 1),
        [&](const RayBlock& block, Eigen::Index first, int used) {
          const NominalBlock reference(nominal, first, used, block.count);
          double padded[2][kRayPadding];
          double* to_x = used == block.count ? d_tx->data() + first : padded[0];
          double* to_y = used == block.count ? d_ty->data() + first : padded[1];
          if (!kernels.angle_gradient(block, reference.tx(), reference.ty(), scale, mean, to_x, to_y))
            gradient_of_angles(block, reference, scale, mean, to_x, to_y);
          if (used == block.count) return;
          std::copy_n(padded[0], used, d_tx->data() + first);
          std::copy_n(padded[1], used, d_ty->data() + first);
        });
  });
}

}  // namespace aberfit::internal
