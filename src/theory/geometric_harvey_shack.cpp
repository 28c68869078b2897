#include "aberfit/theory/geometric_harvey_shack.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/root.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

// Nodes per piece of the radial quadrature, and the spread up to which each keeps encircled energies within
// 1e-11 of 700 nodes. Valid for circles, annuli, rectangles and polygons;
// RadialNodesSufficeForTheSpreadTheyServe measures it for circles.
constexpr std::array<int, 9> kDoublings{16, 24, 32, 48, 64, 96, 128, 256, 512};
constexpr std::array<double, 8> kSpreads{8, 14, 20, 30, 38, 60, 78, 160};

constexpr int kBitsOfPlace = 26;

}  // namespace

GeometricHarveyShack::GeometricHarveyShack(const Mirror& mirror, const Aperture& aperture, double slope,
                                           Convention convention, double rms_height)
    : focal_length_(mirror.focal_length), aperture_radius_(aberfit::aperture_radius(aperture)) {
  const bool physical = convention == Convention::kPhysical;
  focal_sigma_ = (physical ? 2.0 : 1.0) * mirror.focal_length * slope;
  rms_height_ = physical ? rms_height : 0.5 * rms_height;
  Mirror of_revolution = mirror;
  std::erase_if(of_revolution.zernike, [](const KnownZernike& term) { return term.mode.m != 0; });
  for (const int n : kDoublings) {
    std::vector<Zone>& level = levels_.emplace_back();
    for (const RadialNode& node : radial_quadrature(aperture, n)) {
      const SurfacePoint<double> surface = base_surface(of_revolution, node.rho, 0.0);
      const double p2 = surface.slope_x * surface.slope_x;
      if (!(p2 < 1.0))
        throw ComputationError(
            fmt::format("from {:.4g} m off its axis the mirror sends no light to the focus, because its "
                        "slope there is {:.3g}",
                        node.rho, surface.slope_x));
      const Ray<double> ray = reflect(mirror.focal_length, node.rho, 0.0, surface);
      const double path = mirror.focal_length - surface.height, cosine = (1.0 - p2) / (1.0 + p2);
      Zone zone{};
      zone.weight = node.weight;
      zone.rho = node.rho;
      zone.offset = ray.x;
      zone.offset_per_dz = ray.tx;
      if (physical) {
        zone.sigma_radial_per_dz = 2.0 * slope * (1.0 + p2) / ((1.0 - p2) * (1.0 - p2));
        zone.sigma_tangential_per_dz = 2.0 * slope / (1.0 - p2);
        zone.angle_radial = zone.angle_tangential = 2.0 * slope / (1.0 + p2);
      } else {
        zone.sigma_radial_per_dz = zone.sigma_tangential_per_dz = slope / cosine;
        zone.angle_radial = slope * cosine;
        zone.angle_tangential = slope;
      }
      zone.sigma_radial = path * zone.sigma_radial_per_dz;
      zone.sigma_tangential = path * zone.sigma_tangential_per_dz;
      level.push_back(zone);
    }
  }
}

const std::vector<GeometricHarveyShack::Zone>& GeometricHarveyShack::zones(double dz) const {
  // Spread: how many standard deviations the nominal ray would move over the aperture at its fastest rate.
  const std::vector<Zone>& coarse = levels_.front();
  double rate = 0, sigma = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const Zone& zone = coarse[i];
    sigma = std::min(sigma, std::abs(zone.sigma_tangential + dz * zone.sigma_tangential_per_dz));
    if (i == 0) continue;
    const Zone& last = coarse[i - 1];
    const double moved = zone.offset - last.offset + dz * (zone.offset_per_dz - last.offset_per_dz);
    rate = std::max(rate, std::abs(moved / (zone.rho - last.rho)));
  }
  std::size_t level = 0;
  while (level < kSpreads.size() && !(rate * aperture_radius_ <= kSpreads[level] * sigma)) ++level;
  return levels_[level];
}

struct GeometricHarveyShack::Sums {
  double share = 0;
  double d_radius = 0;
  double d_plane = 0;
  double d_slope = 0;  // over ln(slope), because the standard deviations are proportional to it
};

GeometricHarveyShack::Sums GeometricHarveyShack::sums(double radius, double dz) const {
  Sums total;
  for (const Zone& zone : zones(dz)) {
    const double offset = zone.offset + dz * zone.offset_per_dz;
    double radial = zone.sigma_radial + dz * zone.sigma_radial_per_dz;
    double tangential = zone.sigma_tangential + dz * zone.sigma_tangential_per_dz;
    if (radial == 0 || tangential == 0) {  // the nominal ray is inside or outside
      total.share += zone.weight * (std::abs(offset) <= radius ? 1.0 : 0.0);
      continue;
    }
    // Behind the mirror's own height the path is negative, and so are the linear standard deviations.
    const double sign = radial < 0 ? -1.0 : 1.0;
    const DiscShare disc = gaussian_in_disc(radius, offset, sign * radial, sign * tangential, rules_);
    total.share += zone.weight * disc.value;
    total.d_radius += zone.weight * disc.d_radius;
    total.d_slope +=
        zone.weight * sign * (disc.d_sigma_radial * radial + disc.d_sigma_tangential * tangential);
    total.d_plane += zone.weight * (disc.d_offset * zone.offset_per_dz +
                                    sign * (disc.d_sigma_radial * zone.sigma_radial_per_dz +
                                            disc.d_sigma_tangential * zone.sigma_tangential_per_dz));
  }
  return total;
}

double GeometricHarveyShack::encircled_energy(double radius, double dz) const {
  return sums(radius, dz).share;
}

double GeometricHarveyShack::encircled_energy_slope(double radius, double dz) const {
  return sums(radius, dz).d_radius;
}

double GeometricHarveyShack::radius_over_slope(double radius, double dz) const {
  const Sums at = sums(radius, dz);
  return at.d_radius > 0 ? -at.d_slope / at.d_radius : 0;
}

double GeometricHarveyShack::encircled_energy_radius(double fraction, double dz) const {
  if (!(fraction > 0 && fraction < 1)) return kNaN;
  const double rms = rms_radius(dz);
  if (!(rms > 0)) return rms;  // all rays meet in one point
  double low = 0, high = std::numeric_limits<double>::infinity();
  double radius = rms * std::sqrt(-std::log1p(-fraction));  // exact for a round Gaussian
  for (int i = 0; i < 200; ++i) {
    const Sums at = sums(radius, dz);
    (at.share < fraction ? low : high) = radius;
    const double newton = (fraction - at.share) / at.d_radius;
    // Newton squares the relative step, times at most radius / sigma for the curvature.
    if (std::abs(newton) <= 1e-8 * radius) return radius + newton;
    double next = radius + newton;
    if (!(next > low && next < high)) next = std::isinf(high) ? 2.0 * radius : 0.5 * (low + high);
    if (std::isfinite(high) && high - low <= 1e-15 * high)
      return high;  // a stair has no slope: bisection to rounding
    radius = next;
  }
  return radius;
}

double GeometricHarveyShack::ring_peak(double ring_radius) const {
  if (!(ring_radius > 0)) return kNaN;
  // Planes where zones cross the axis. A cone of rays fills the ring up to ring / offset_per_dz from there.
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const Zone& zone : levels_.front()) {
    first = std::min(first, -zone.offset / zone.offset_per_dz);
    last = std::max(last, -zone.offset / zone.offset_per_dz);
  }
  const double depth = focal_length_ / aperture_radius_ * std::hypot(ring_radius, focal_sigma_);
  const int half_steps = std::clamp(int(2.0 * (last - first) / depth) + 4, 4, 400);
  const double middle = 0.5 * (first + last);
  const double step = std::max(0.25 * depth, 0.5 * (last - first + depth) / half_steps);
  int best = 0;
  double most = -1;
  for (int i = -half_steps; i <= half_steps; ++i) {
    const double share = encircled_energy(ring_radius, middle + i * step);
    if (share > most) most = share, best = i;
  }
  double low = middle + (best - 1) * step, high = middle + (best + 1) * step;
  const auto derivative = [&](double dz) { return sums(ring_radius, dz).d_plane; };
  const double at_low = derivative(low), at_high = derivative(high);
  if (!(at_low > 0 && at_high < 0)) return middle + best * step;  // a flat or stepped top
  return root_between(derivative, low, high, at_low, at_high);
}

double GeometricHarveyShack::ring_fwhm(double ring_radius) const {
  const double peak = ring_peak(ring_radius);
  if (std::isnan(peak)) return kNaN;
  const double half = 0.5 * encircled_energy(ring_radius, peak);
  const double depth = focal_length_ / aperture_radius_ * std::hypot(ring_radius, focal_sigma_);
  const auto excess = [&](double dz) { return encircled_energy(ring_radius, dz) - half; };
  double width = 0;
  for (const double side : {-1.0, 1.0})
    width += side * (first_crossing(excess, peak, half, side * 0.5 * depth, 0.5 * focal_length_) - peak);
  return width;
}

double GeometricHarveyShack::rms_radius(double dz) const {
  double sum = 0;
  for (const Zone& zone : levels_.front()) {
    const double offset = zone.offset + dz * zone.offset_per_dz;
    const double radial = zone.sigma_radial + dz * zone.sigma_radial_per_dz;
    const double tangential = zone.sigma_tangential + dz * zone.sigma_tangential_per_dz;
    sum += zone.weight * (offset * offset + radial * radial + tangential * tangential);
  }
  return std::sqrt(sum);
}

double GeometricHarveyShack::scatter_rms() const {
  double sum = 0;
  for (const Zone& zone : levels_.front())
    sum +=
        zone.weight * (zone.angle_radial * zone.angle_radial + zone.angle_tangential * zone.angle_tangential);
  return std::sqrt(sum);
}

double GeometricHarveyShack::scatter_mean() const {
  double sum = 0;
  for (const Zone& zone : levels_.front()) {
    const double major = std::max(zone.angle_radial, zone.angle_tangential);
    const double minor = std::min(zone.angle_radial, zone.angle_tangential);
    if (major == 0) continue;
    const double modulus = std::sqrt((1.0 - minor / major) * (1.0 + minor / major));
    sum += zone.weight * std::numbers::sqrt2 * std::numbers::inv_sqrtpi * major * std::comp_ellint_2(modulus);
  }
  return sum;
}

double GeometricHarveyShack::spot_fwhm(double bandwidth) const {
  struct Line {
    double weight, offset, sigma;
  };
  std::vector<Line> lines;  // profiles of the zones in `azimuths` directions of one quadrant
  const std::vector<Zone>& all = zones(0.0);
  const int azimuths = 8 * int(all.size() / levels_.front().size());
  double reach = 0, narrowest = std::numeric_limits<double>::infinity();
  for (const Zone& zone : all)
    for (int k = 0; k < azimuths; ++k) {
      const double angle = 0.5 * std::numbers::pi * (k + 0.5) / azimuths;
      const double sigma =
          std::hypot(zone.sigma_radial * std::cos(angle), zone.sigma_tangential * std::sin(angle), bandwidth);
      lines.push_back({zone.weight / azimuths, zone.offset * std::cos(angle), sigma});
      narrowest = std::min(narrowest, sigma);
      reach = std::max(reach, std::abs(lines.back().offset) + 3.0 * sigma);
    }
  if (!(narrowest > 0)) return kNaN;
  const auto profile = [&](double x) {
    double sum = 0;
    for (const Line& line : lines) {
      const double u = (x - line.offset) / line.sigma, v = (x + line.offset) / line.sigma;
      sum += line.weight / line.sigma * (std::exp(-0.5 * u * u) + std::exp(-0.5 * v * v));
    }
    return sum;
  };
  // The profile is even. Scan for its top, then for the outermost point above half of it.
  const double step = std::max(0.25 * narrowest, reach / 4000);
  const int steps = int(reach / step) + 1;
  std::vector<double> scan;
  for (int i = 0; i <= steps; ++i) scan.push_back(profile(i * step));
  const int top = int(std::max_element(scan.begin(), scan.end()) - scan.begin());
  double most = scan[std::size_t(top)];
  if (top > 0) {  // the value at a maximum needs only half the digits of its position
    const auto below = [&](double x) { return -profile(x); };
    most = -boost::math::tools::brent_find_minima(below, (top - 1) * step, (top + 1) * step, kBitsOfPlace)
                .second;
  }
  const auto excess = [&](double x) { return profile(x) - 0.5 * most; };
  int last = steps;
  while (scan[std::size_t(last)] <= 0.5 * most) --last;
  const double low = last * step, high = (last + 1) * step;
  return 2.0 * root_between(excess, low, high, excess(low), excess(high));
}

}  // namespace aberfit
