#include "light_guides.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/parallel.h"

namespace aberfit::internal {
namespace {

// Between the innermost and this share of the light; outside of it rings hold too many grains to vary.
constexpr double kInnermost = 0.2, kOutermost = 0.9;
// Rings are half a grain apart, the sampling of a pattern that has no finer frequency than 1 / grain, or as
// far as the grains on a ring, of which there are 2 pi r / grain, keep the share between two rings to this
// many margins. With three quarters of a grain, eleven of sixty heights of the README's roughness (g 0.2 to
// 10) ended different, ee25 between two rings off by 1.1 to 2 %; 226 and 241 nm still do.
constexpr double kRingsInGrains = 0.5, kSteadyRing = 1.5;
// Planes are three quarters of a grain's depth apart, or as far as the cone of light widens by so many steady
// ring distances. The worst held-out statistic of the README's study at n = 30 by this factor: 3, 1.0 %; 5,
// 0.8 %; without guides beyond two plane units, 2 %. With 5 one of seven seeds at g = 5 missed a plane
// between two of them by 1.1 %, with 4 none.
constexpr double kPlanesInDepths = 0.75, kSteadyPlane = 4;
// Where margins are small beside what grains do, guides end here: their cost would have no bound. Rings have
// at least this share of the light between them, not this distance: a halo is hundreds of grains wide.
constexpr double kLeastShare = 0.7 / 16;
constexpr int kMostPlanesBetween = 8;

struct Grain {
  double across, f_number, margin;
  double steady(double radius) const {
    return margin * radius * std::sqrt(2 * std::numbers::pi * radius / across);
  }
  double ring_step(double radius) const {
    return std::max(kRingsInGrains * across, kSteadyRing * steady(radius));
  }
  double plane_step(double radius) const {
    const double depth = 8 * across * f_number;
    return std::max(kPlanesInDepths * depth, kSteadyPlane * 2 * f_number * steady(radius));
  }
};

std::vector<double> planes_between(const Groundwork& ground, const Grain& grain, std::vector<double> fitted) {
  std::sort(fitted.begin(), fitted.end());
  std::vector<double> planes = {fitted.front()};
  for (std::size_t k = 0; k + 1 < fitted.size(); ++k) {
    const double low = fitted[k], high = fitted[k + 1];
    const double radius = ground.mean_spot->encircled_energy_radius(0.3, 0.5 * (low + high));
    const double parts =
        std::clamp(std::ceil((high - low) / grain.plane_step(radius)), 1.0, double(kMostPlanesBetween));
    for (int j = 1; j <= int(parts); ++j) planes.push_back(low + (high - low) * j / parts);
  }
  return planes;
}

std::vector<Target> guides_in(const MeanSpot& spot, const Grain& grain, double dz, double tolerance) {
  const double low = spot.encircled_energy_radius(kInnermost),
               high = spot.encircled_energy_radius(kOutermost);
  std::vector<Target> guides;
  for (double radius = low, share = kInnermost; radius < high;) {
    Target guide;
    guide.statistic = RingThrough{radius, dz};
    guide.value = share = spot.encircled_energy(radius);
    guide.scale = std::max(radius * spot.encircled_energy_slope(radius), kFlattestCurve);
    guide.tolerance = tolerance * guide.scale;
    guides.push_back(guide);
    radius += grain.ring_step(radius);
    share += kLeastShare;
    if (share >= kOutermost) break;
    radius = std::max(radius, spot.encircled_energy_radius(share));
  }
  return guides;
}

}  // namespace

std::vector<Target> light_guides(const Task& task, const Groundwork& ground,
                                 const std::vector<double>& planes, double tolerance, int threads) {
  const double f_number = ground.focal_length / (2 * ground.radius);
  const Grain grain{task.wavelength * f_number, f_number, task.equivalence.margin};
  const std::vector<double> all = planes_between(ground, grain, planes);
  std::vector<std::vector<Target>> guides(all.size());
  parallel_for(all.size(), threads, [&](std::size_t k) {
    guides[k] = guides_in(ground.mean_spot->at_plane(all[k]), grain, all[k], tolerance);
  });
  std::vector<Target> flat;
  for (const std::vector<Target>& in_plane : guides)
    flat.insert(flat.end(), in_plane.begin(), in_plane.end());
  return flat;
}

}  // namespace aberfit::internal
