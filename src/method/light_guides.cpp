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
// between two of them by 1.1 %, with 4 none. Half a depth is the sampling of a pattern through focus: below a
// margin of 1 % planes come that near.
constexpr double kPlanesInDepths = 0.75, kNearestInDepths = 0.5, kSteadyPlane = 4;
// Where margins are small beside what grains do, guides end here: their cost would have no bound. Rings have
// at least this share of the light between them, not this distance: a halo is hundreds of grains wide. Both
// ends are those of a margin of 1 % and go on below it: with those of 1 % the README's study ended different
// at 0.3 %, six of 156 statistics off by up to 0.45 % whatever the number of terms; now it is equivalent
// there in two minutes. At 0.1 % it is not, with four times the guides or seven: 0.25 % off.
constexpr double kSmallestMargin = 0.001, kUsualMargin = 0.01;
constexpr double kLeastShare = 0.7 / 16;
constexpr double kMostPlanesBetween = 8, kMostAtSmallMargins = 16;

struct Grain {
  double across, f_number, margin;
  double below_usual() const { return std::clamp(margin, kSmallestMargin, kUsualMargin) / kUsualMargin; }
  double least_share() const { return kLeastShare * below_usual(); }
  double most_planes() const { return std::min(kMostPlanesBetween / below_usual(), kMostAtSmallMargins); }
  double steady(double radius) const {
    return margin * radius * std::sqrt(2 * std::numbers::pi * radius / across);
  }
  double ring_step(double radius) const {
    return std::max(kRingsInGrains * across, kSteadyRing * steady(radius));
  }
  double plane_step(double radius) const {
    const double depth = 8 * across * f_number;
    const double in_depths = std::max(kPlanesInDepths * below_usual(), kNearestInDepths);
    return std::max(in_depths * depth, kSteadyPlane * 2 * f_number * steady(radius));
  }
};

std::vector<double> planes_between(const Groundwork& ground, const Grain& grain, std::vector<double> fitted) {
  std::sort(fitted.begin(), fitted.end());
  std::vector<double> planes = {fitted.front()};
  for (std::size_t k = 0; k + 1 < fitted.size(); ++k) {
    const double low = fitted[k], high = fitted[k + 1];
    const double radius = ground.mean_spot->encircled_energy_radius(0.3, 0.5 * (low + high));
    const double parts =
        std::clamp(std::ceil((high - low) / grain.plane_step(radius)), 1.0, std::floor(grain.most_planes()));
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
    share += grain.least_share();
    if (share >= kOutermost) break;
    radius = std::max(radius, spot.encircled_energy_radius(share));
  }
  return guides;
}

// Of three starts of a deep spot (g 14, 1,173 terms, 132 residuals) none was equivalent with the tolerance of
// few terms (between the targets 1.8 to 2.4 margins off), two with a third of it (0.8 to 1.3). Fits of the
// README's study, of 168 terms, take three times the iterations with a third.
constexpr double kClosest = 1.0 / 3, kToSpare = 2;

}  // namespace

void hold_closer(std::size_t targets, Eigen::Index terms, std::vector<Target>* guides) {
  const double residuals = double(targets + guides->size());
  const double closer = std::clamp(kToSpare * residuals / double(terms), kClosest, 1.0);
  for (Target& guide : *guides)
    if (plane_of_light(guide.statistic)) guide.tolerance *= closer;
}

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
