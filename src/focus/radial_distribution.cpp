#include "radial_distribution.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace aberfit {
namespace {

constexpr std::size_t kBins = 1024;      // plus one for what lies beyond
constexpr double kBinnedRangeInRms = 4;  // bins cover this many RMS radii

}  // namespace

RadialDistribution::RadialDistribution(const RayBundle& rays, double dz, bool about_centroid)
    : rays_(rays), dz_(dz), about_centroid_(about_centroid) {
  const auto n = std::size_t(rays.size());
  total_ = rays.weight.sum();
  if (about_centroid && total_ > 0) {
    centre_x_ = (rays.weight * (rays.x + dz * rays.tx)).sum() / total_;
    centre_y_ = (rays.weight * (rays.y + dz * rays.ty)).sum() / total_;
  }
  radius_.resize(n);
  double moment = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = Eigen::Index(i);
    const double x = rays.x[k] + dz * rays.tx[k] - centre_x_, y = rays.y[k] + dz * rays.ty[k] - centre_y_;
    const double r2 = x * x + y * y;
    radius_[i] = std::sqrt(r2);
    moment += rays.weight[k] * r2;
  }
  rms_ = total_ > 0 ? std::sqrt(moment / total_) : 0.0;
  bins_per_metre_ = rms_ > 0 ? double(kBins) / (kBinnedRangeInRms * rms_) : 0.0;

  first_.assign(kBins + 2, 0);
  weight_before_.assign(kBins + 2, 0.0);
  std::vector<std::uint16_t> bin(n);
  for (std::size_t i = 0; i < n; ++i) {
    bin[i] = std::uint16_t(bin_of(radius_[i]));
    ++first_[bin[i] + 1u];
    weight_before_[bin[i] + 1u] += rays.weight[Eigen::Index(i)];
  }
  for (std::size_t b = 0; b <= kBins; ++b) {
    first_[b + 1] += first_[b];
    weight_before_[b + 1] += weight_before_[b];
  }
  order_.resize(n);
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < n; ++i) order_[next[bin[i]]++] = std::uint32_t(i);
}

std::size_t RadialDistribution::bin_of(double r) const {
  return std::size_t(std::clamp(r * bins_per_metre_, 0.0, double(kBins)));
}

double RadialDistribution::exact_radius(double fraction) const {
  const double wanted = fraction * total_;
  if (!(total_ > 0)) return std::nan("");
  std::size_t low = std::size_t(std::upper_bound(weight_before_.begin(), weight_before_.end(), wanted) -
                                weight_before_.begin());
  low = std::clamp<std::size_t>(low, 1, kBins + 1) - 1;
  std::size_t high = low + 1;
  // Half weights at both ends may make a neighbour bin's ray the partner of the interpolation.
  const auto widen_down = [&] {
    while (low > 0) {
      --low;
      if (first_[low] != first_[low + 1]) break;
    }
  };
  const auto widen_up = [&] {
    while (high < kBins + 1) {
      ++high;
      if (first_[high] != first_[high - 1]) break;
    }
  };
  widen_down();
  widen_up();
  std::vector<std::uint32_t> near(order_.begin() + first_[low], order_.begin() + first_[high]);
  std::sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) {
    return radius_[a] < radius_[b] || (radius_[a] == radius_[b] && a < b);
  });
  double sum = weight_before_[low], previous_sum = 0, previous_radius = 0;
  bool first = true;
  for (const std::uint32_t i : near) {
    const double weight = rays_.weight[Eigen::Index(i)];
    const double here = sum + 0.5 * weight;
    sum += weight;
    if (here >= wanted) {
      if (first || here == previous_sum) return radius_[i];
      return previous_radius +
             (radius_[i] - previous_radius) * (wanted - previous_sum) / (here - previous_sum);
    }
    previous_sum = here;
    previous_radius = radius_[i];
    first = false;
  }
  return previous_radius;
}

template <typename Visit>
void RadialDistribution::visit_shell(const SmoothDisc& disc, const Visit& visit) const {
  const std::size_t low = bin_of(std::sqrt(std::max(0.0, disc.inside2))),
                    high = bin_of(std::sqrt(disc.outside2));
  for (std::uint32_t k = first_[low]; k < first_[high + 1]; ++k) {
    const std::uint32_t i = order_[k];
    visit(i, radius_[i] * radius_[i]);
  }
}

RadialDistribution::Count RadialDistribution::smooth_count(double radius, double width) const {
  const SmoothDisc disc(radius, width);
  Count count{weight_before_[bin_of(std::sqrt(std::max(0.0, disc.inside2)))], 0.0};
  visit_shell(disc, [&](std::uint32_t i, double r2) {
    const double weight = rays_.weight[Eigen::Index(i)];
    count.weight += weight * disc.share(r2);
    count.density += weight * disc.d_radius(disc.density(r2), r2);
  });
  return count;
}

std::optional<double> RadialDistribution::smooth_radius(double fraction, double width) const {
  const double wanted = fraction * total_;
  const double exact = exact_radius(fraction);
  if (!(exact > kSmallestSpotInWidths * width)) return std::nullopt;
  double radius = exact, low = 0, high = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Count count = smooth_count(radius, width);
    const double excess = count.weight - wanted;
    (excess > 0 ? high : low) = radius;
    if (count.density > 0) {
      const double step = excess / count.density;
      if (std::abs(step) <= 1e-11 * radius) return radius - step;  // quadratic: the next step would be rounding
      radius -= step;
    }
    if (!(count.density > 0) || !(radius > low && radius < high))
      radius = std::isfinite(high) ? 0.5 * (low + high) : 2 * low;
    if (std::isfinite(high) && high - low <= 1e-15 * high) break;
  }
  if (smooth_count(radius, width).density > 0) return radius;
  return std::nullopt;
}

void RadialDistribution::count_gradient(double radius, double width, double scale,
                                        RayGradient* gradient) const {
  const SmoothDisc disc(radius, width);
  double centre_d_x = 0, centre_d_y = 0;
  const auto append = [&](std::uint32_t i, double d_x, double d_y) {
    gradient->rays.push_back(i);
    gradient->d_x.push_back(d_x);
    gradient->d_y.push_back(d_y);
    gradient->d_tx.push_back(dz_ * d_x);
    gradient->d_ty.push_back(dz_ * d_y);
  };
  visit_shell(disc, [&](std::uint32_t i, double r2) {
    const auto k = Eigen::Index(i);
    const double share = -2 * scale * rays_.weight[k] * disc.density(r2);
    if (share == 0.0) return;
    const double d_x = share * (rays_.x[k] + dz_ * rays_.tx[k] - centre_x_);
    const double d_y = share * (rays_.y[k] + dz_ * rays_.ty[k] - centre_y_);
    append(i, d_x, d_y);
    centre_d_x -= d_x;
    centre_d_y -= d_y;
  });
  if (!about_centroid_) return;
  for (std::uint32_t i = 0; i < radius_.size(); ++i) {  // the centre moves with every ray
    const double share = rays_.weight[Eigen::Index(i)] / total_;
    if (share != 0.0) append(i, share * centre_d_x, share * centre_d_y);
  }
}

void RadialDistribution::radius_gradient(double radius, double width, double scale,
                                         RayGradient* gradient) const {
  // Implicit function theorem on count(radius) = fraction * total: d radius = -d count / density.
  count_gradient(radius, width, -scale / smooth_count(radius, width).density, gradient);
}

}  // namespace aberfit
