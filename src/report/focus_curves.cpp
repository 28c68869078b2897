#include "focus_curves.h"

#include <algorithm>
#include <cmath>

namespace aberfit::internal {
namespace {

struct Point {
  double x = 0, y = 0;
};

Point centre_of(const RayBundle& rays, Centre centre, double dz) {
  Point mean;
  if (centre == Centre::kNominal) return mean;
  double total = 0;
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const double weight = rays.weight[i];
    if (weight == 0) continue;  // a lost ray has no crossing
    total += weight;
    mean.x += weight * (rays.x[i] + dz * rays.tx[i]);
    mean.y += weight * (rays.y[i] + dz * rays.ty[i]);
  }
  return {mean.x / total, mean.y / total};
}

// Index of the first grid value that is not below `value`.
Eigen::Index first_not_below(const Eigen::ArrayXd& grid, double value) {
  return std::lower_bound(grid.begin(), grid.end(), value) - grid.begin();
}

Eigen::ArrayXd running_share(const Eigen::ArrayXd& steps, double total) {
  Eigen::ArrayXd share(steps.size());
  double sum = 0;
  for (Eigen::Index i = 0; i < steps.size(); ++i) share[i] = (sum += steps[i]) / total;
  return share;
}

}  // namespace

double ray_statistic(const RayBundle& rays, const RayBundle& nominal, Centre centre,
                     const Statistic& statistic) {
  static const Eigen::ArrayXd kNoHeight;
  return evaluate_exact({rays, nominal, kNoHeight, centre}, {statistic}, 1)[0];
}

Eigen::ArrayXd encircled_energy_curve(const RayBundle& rays, Centre centre, double dz,
                                      const Eigen::ArrayXd& radii) {
  const Point c = centre_of(rays, centre, dz);
  Eigen::ArrayXd steps = Eigen::ArrayXd::Zero(radii.size());
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays.weight[i] == 0) continue;
    const double radius = std::hypot(rays.x[i] + dz * rays.tx[i] - c.x, rays.y[i] + dz * rays.ty[i] - c.y);
    const Eigen::Index k = first_not_below(radii, radius);
    if (k < radii.size()) steps[k] += rays.weight[i];
  }
  return running_share(steps, rays.weight.sum());
}

Eigen::ArrayXd ring_through_curve(const RayBundle& rays, Centre centre, double radius,
                                  const Eigen::ArrayXd& planes) {
  const Point c = centre_of(rays, centre, 0.0);
  Eigen::ArrayXd steps = Eigen::ArrayXd::Zero(planes.size() + 1);
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays.weight[i] == 0) continue;
    const double x = rays.x[i] - c.x, y = rays.y[i] - c.y, tx = rays.tx[i], ty = rays.ty[i];
    // |x + dz t| <= radius between the roots of t2 dz^2 + 2 xt dz + (x2 - radius^2).
    const double t2 = tx * tx + ty * ty, xt = x * tx + y * ty;
    double enter = -HUGE_VAL, leave = HUGE_VAL;
    if (t2 > 0) {
      const double across =
          (x * ty - y * tx) / std::sqrt(t2);  // distance of the ray from the axis of the ring
      if (std::abs(across) > radius) continue;
      const double half = std::sqrt((radius - across) * (radius + across) / t2);
      enter = -xt / t2 - half;
      leave = -xt / t2 + half;
    } else if (std::hypot(x, y) > radius) {
      continue;
    }
    const Eigen::Index first = first_not_below(planes, enter);
    const Eigen::Index end = std::upper_bound(planes.begin(), planes.end(), leave) - planes.begin();
    if (end <= first) continue;
    steps[first] += rays.weight[i];
    steps[end] -= rays.weight[i];
  }
  return running_share(steps, rays.weight.sum()).head(planes.size());
}

Eigen::ArrayXXd focal_image(const RayBundle& rays, Centre centre, double dz, double half_width, int pixels) {
  const Point c = centre_of(rays, centre, dz);
  const double total = rays.weight.sum(), per_metre = pixels / (2.0 * half_width);
  Eigen::ArrayXXd image = Eigen::ArrayXXd::Zero(pixels, pixels);
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays.weight[i] == 0) continue;
    const double u = (rays.x[i] + dz * rays.tx[i] - c.x + half_width) * per_metre - 0.5;
    const double v = (rays.y[i] + dz * rays.ty[i] - c.y + half_width) * per_metre - 0.5;
    if (!(u > -1 && v > -1 && u < pixels && v < pixels)) continue;
    const int column = int(std::floor(u)), row = int(std::floor(v));
    for (int b = 0; b < 2; ++b) {
      for (int a = 0; a < 2; ++a) {
        if (row + b < 0 || row + b >= pixels || column + a < 0 || column + a >= pixels) continue;
        const double share = (1.0 - std::abs(u - (column + a))) * (1.0 - std::abs(v - (row + b)));
        image(row + b, column + a) += share * rays.weight[i] / total;
      }
    }
  }
  return image;
}

Eigen::ArrayXd weighted_density(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weights, double low,
                                double high, int bins) {
  Eigen::ArrayXd density = Eigen::ArrayXd::Zero(bins);
  const double per_unit = bins / (high - low), total = weights.sum();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double bin = std::floor((values[i] - low) * per_unit);
    if (bin >= 0 && bin < bins) density[Eigen::Index(bin)] += weights[i];
  }
  return density * (per_unit / total);
}

}  // namespace aberfit::internal
