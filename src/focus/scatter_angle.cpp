#include "scatter_angle.h"

#include <cmath>

namespace aberfit {
namespace {

// Cross product of (tx, ty, 1) with (vx, vy, 1), its length and the dot product.
struct Pair {
  double cx, cy, cz, cross, dot;
  Pair(double tx, double ty, double vx, double vy)
      : cx(ty - vy), cy(vx - tx), cz((tx - vx) * vy - (ty - vy) * vx) {
    cross = std::sqrt(cx * cx + cy * cy + cz * cz);
    dot = tx * vx + ty * vy + 1.0;
  }
};

}  // namespace

Eigen::ArrayXd scatter_angles(const RayBundle& rays, const RayBundle& nominal) {
  Eigen::ArrayXd angle(rays.size());
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const Pair pair(rays.tx[i], rays.ty[i], nominal.tx[i], nominal.ty[i]);
    angle[i] = std::atan2(pair.cross, pair.dot);
  }
  return angle;
}

void squared_angle_gradient(const RayBundle& rays, const RayBundle& nominal, const Eigen::ArrayXd& weights,
                            Eigen::ArrayXd* d_tx, Eigen::ArrayXd* d_ty) {
  d_tx->resize(rays.size());
  d_ty->resize(rays.size());
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const double vx = nominal.tx[i], vy = nominal.ty[i];
    const Pair pair(rays.tx[i], rays.ty[i], vx, vy);
    // angle = atan2(cross, dot): d(angle^2/2) = (angle/cross) (dot cross dcross - cross^2 ddot) / (cross^2 +
    // dot^2).
    const double ratio = pair.cross > 0 ? std::atan2(pair.cross, pair.dot) / pair.cross : 1.0 / pair.dot;
    const double scale = weights[i] * ratio / (pair.cross * pair.cross + pair.dot * pair.dot);
    const double cross2 = pair.cross * pair.cross;
    (*d_tx)[i] = scale * (pair.dot * (-pair.cy + pair.cz * vy) - cross2 * vx);
    (*d_ty)[i] = scale * (pair.dot * (pair.cx - pair.cz * vx) - cross2 * vy);
  }
}

}  // namespace aberfit
