#include "ring_through.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernel.h"

namespace aberfit {
namespace {

constexpr int kPlanes = 4096;  // over the search range
constexpr double kFirstRange =
    8;  // half range in ring / RMS ray slope; the half maximum of a Gaussian focus lies near 1
constexpr double kLastRange = 128;

struct Profile {
  double first = 0, pitch = 0;  // dz of plane 0 and distance of planes [m]
  std::vector<double> share;    // N at every plane
  double at(std::size_t k) const { return first + pitch * double(k); }
};

double rms_slope(const RayBundle& rays) {
  const double total = rays.weight.sum();
  return std::sqrt((rays.weight * (rays.tx.square() + rays.ty.square())).sum() / total);
}

Profile count_planes(const RayBundle& rays, double ring, double cx, double cy, double half_range) {
  Profile profile{-half_range, 2 * half_range / kPlanes, std::vector<double>(kPlanes + 2, 0.0)};
  // A ray is inside between the two roots of |X0 + z T|^2 = ring^2: it enters at the first plane at or above
  // the lower root and leaves at the first plane above the upper one.
  const auto plane_from = [&](double z) {
    return std::size_t(std::clamp(std::ceil((z - profile.first) / profile.pitch), 0.0, double(kPlanes + 1)));
  };
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const double x = rays.x[i] - cx, y = rays.y[i] - cy, tx = rays.tx[i], ty = rays.ty[i];
    const double a = tx * tx + ty * ty, b = x * tx + y * ty, c = x * x + y * y - ring * ring;
    if (a == 0.0) {
      if (c <= 0.0) profile.share[0] += rays.weight[i];
      continue;
    }
    const double discriminant = b * b - a * c;
    if (discriminant <= 0.0) continue;
    const double root = std::sqrt(discriminant);
    profile.share[plane_from((-b - root) / a)] += rays.weight[i];
    profile.share[plane_from((-b + root) / a)] -= rays.weight[i];
  }
  for (std::size_t k = 1; k < profile.share.size(); ++k) profile.share[k] += profile.share[k - 1];
  profile.share.resize(kPlanes + 1);
  return profile;
}

std::optional<RingWidth> width_of(const Profile& profile) {
  const std::vector<double>& n = profile.share;
  RingWidth width;
  // The middle of the planes that share the largest count (a plateau for an aberration-free focus).
  const auto highest = std::max_element(n.begin(), n.end());
  auto plateau_end = highest;
  while (plateau_end + 1 != n.end() && *(plateau_end + 1) == *highest) ++plateau_end;
  const auto first = std::size_t(highest - n.begin()), last = std::size_t(plateau_end - n.begin());
  width.peak = 0.5 * (profile.at(first) + profile.at(last));
  width.peak_share = *highest;
  const double half = 0.5 * *highest;
  const auto crossing = [&](std::size_t inside, std::size_t outside) {
    return profile.at(inside) +
           (profile.at(outside) - profile.at(inside)) * (n[inside] - half) / (n[inside] - n[outside]);
  };
  std::size_t k = first;
  while (k > 0 && n[k - 1] >= half) --k;
  if (k == 0) return std::nullopt;
  width.lower = crossing(k, k - 1);
  for (k = last; k + 1 < n.size() && n[k + 1] >= half;) ++k;
  if (k + 1 == n.size()) return std::nullopt;
  width.upper = crossing(k, k + 1);
  width.fwhm = width.upper - width.lower;
  width.crossings = 0;
  for (k = 1; k < n.size(); ++k) width.crossings += (n[k] >= half) != (n[k - 1] >= half);
  return width;
}

// N(z) and its derivatives with the smooth indicator.
class SmoothShare {
 public:
  SmoothShare(const RayBundle& rays, double ring, double cx, double cy, double width)
      : rays_(rays), disc_(ring, width), cx_(cx), cy_(cy), total_(rays.weight.sum()) {}

  struct Value {
    double share, d_z, d_ring;
  };
  Value operator()(double z) const {
    Value value{0, 0, 0};
    for (Eigen::Index i = 0; i < rays_.size(); ++i) {
      const double x = rays_.x[i] + z * rays_.tx[i] - cx_, y = rays_.y[i] + z * rays_.ty[i] - cy_;
      const double r2 = x * x + y * y;
      if (r2 >= disc_.outside2) continue;
      if (r2 <= disc_.inside2) {
        value.share += rays_.weight[i];
        continue;
      }
      const double density = rays_.weight[i] * disc_.density(r2);
      value.share += rays_.weight[i] * disc_.share(r2);
      value.d_ring += disc_.d_radius(density, r2);
      value.d_z -= 2 * density * (x * rays_.tx[i] + y * rays_.ty[i]);
    }
    return {value.share / total_, value.d_z / total_, value.d_ring / total_};
  }

  // Appends scale * dN(z) over the rays.
  void gradient(double z, double scale, RayGradient* gradient) const {
    for (Eigen::Index i = 0; i < rays_.size(); ++i) {
      const double x = rays_.x[i] + z * rays_.tx[i] - cx_, y = rays_.y[i] + z * rays_.ty[i] - cy_;
      const double r2 = x * x + y * y;
      if (r2 >= disc_.outside2 || r2 <= disc_.inside2) continue;
      const double share = -2 * scale / total_ * rays_.weight[i] * disc_.density(r2);
      if (share == 0.0) continue;
      gradient->rays.push_back(std::uint32_t(i));
      gradient->d_x.push_back(share * x);
      gradient->d_y.push_back(share * y);
      gradient->d_tx.push_back(z * share * x);
      gradient->d_ty.push_back(z * share * y);
    }
  }

 private:
  const RayBundle& rays_;
  SmoothDisc disc_;
  double cx_, cy_, total_;
};

// Root of f in [a, b] with f(a) f(b) <= 0 by secant steps kept inside a shrinking bracket (Illinois).
template <typename F>
double bracketed_root(const F& f, double a, double fa, double b, double fb) {
  for (int iteration = 0; iteration < 100 && fa != 0.0 && fb != 0.0; ++iteration) {
    double c = (fa * b - fb * a) / (fa - fb);
    if (!(c > std::min(a, b) && c < std::max(a, b))) c = 0.5 * (a + b);
    const double fc = f(c);
    if ((fc > 0) == (fb > 0)) {
      fa *= 0.5;
    } else {
      a = b;
      fa = fb;
    }
    b = c;
    fb = fc;
    if (std::abs(b - a) <= 1e-15 * (std::abs(a) + std::abs(b))) break;
    if (fc == 0.0) break;
  }
  return fb == 0.0 || std::abs(fb) < std::abs(fa) ? b : a;
}

}  // namespace

std::optional<RingWidth> exact_ring_width(const RayBundle& rays, double ring_radius, double centre_x,
                                          double centre_y) {
  const double slope = rms_slope(rays);
  if (!(ring_radius > 0) || !(slope > 0)) return std::nullopt;
  for (double range = kFirstRange; range <= kLastRange; range *= 4) {
    const auto width =
        width_of(count_planes(rays, ring_radius, centre_x, centre_y, range * ring_radius / slope));
    if (width) {
      RingWidth result = *width;
      result.peak_share /= rays.weight.sum();
      return result;
    }
  }
  return std::nullopt;
}

std::optional<RingWidth> smooth_ring_width(const RayBundle& rays, double ring_radius, double centre_x,
                                           double centre_y, double width, RayGradient* gradient,
                                           double* d_ring) {
  const auto start = exact_ring_width(rays, ring_radius, centre_x, centre_y);
  if (!start || !(ring_radius > kSmallestSpotInWidths * width)) return std::nullopt;
  const SmoothShare share(rays, ring_radius, centre_x, centre_y, width);
  RingWidth result = *start;
  // The peak: where dN/dz changes sign around the counted one. The window grows until it holds a sign change.
  const auto slope_at = [&](double z) { return share(z).d_z; };
  double window = 0.02 * start->fwhm, low = 0, high = 0, f_low = 0, f_high = 0;
  bool bracketed = false;
  for (; window <= 0.4 * start->fwhm && !bracketed; window *= 2) {
    low = start->peak - window;
    high = start->peak + window;
    f_low = slope_at(low);
    f_high = slope_at(high);
    bracketed = f_low >= 0 && f_high <= 0;
  }
  if (!bracketed) return std::nullopt;
  result.peak = f_low == 0 && f_high == 0 ? start->peak : bracketed_root(slope_at, low, f_low, high, f_high);
  const SmoothShare::Value top = share(result.peak);
  result.peak_share = top.share;
  const auto excess = [&](double z) { return share(z).share - 0.5 * top.share; };
  const auto crossing = [&](double counted, double outward) -> std::optional<double> {
    double reach = 0.02 * start->fwhm;
    for (int tries = 0; tries < 6; ++tries, reach *= 2) {
      const double inner = counted - outward * reach, outer = counted + outward * reach;
      const double f_inner = excess(inner), f_outer = excess(outer);
      if (f_inner >= 0 && f_outer <= 0) return bracketed_root(excess, inner, f_inner, outer, f_outer);
    }
    return std::nullopt;
  };
  const auto lower = crossing(start->lower, -1), upper = crossing(start->upper, +1);
  if (!lower || !upper) return std::nullopt;
  result.lower = *lower;
  result.upper = *upper;
  result.fwhm = *upper - *lower;
  if (!gradient && !d_ring) return result;
  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; the peak does not move N(peak) to first
  // order.
  const SmoothShare::Value at_lower = share(*lower), at_upper = share(*upper);
  if (at_lower.d_z == 0.0 || at_upper.d_z == 0.0) return std::nullopt;
  const double for_upper = -1.0 / at_upper.d_z, for_lower = 1.0 / at_lower.d_z;
  const double for_peak = -0.5 * (for_upper + for_lower);
  if (gradient) {
    share.gradient(*upper, for_upper, gradient);
    share.gradient(*lower, for_lower, gradient);
    share.gradient(result.peak, for_peak, gradient);
  }
  if (d_ring) *d_ring = for_upper * at_upper.d_ring + for_lower * at_lower.d_ring + for_peak * top.d_ring;
  return result;
}

}  // namespace aberfit
