#include "light_guides.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "aberfit/core/parallel.h"
#include "aberfit/method/constants.h"

namespace aberfit::internal {
namespace {

// The spacing of rings and planes for one speckle grain. Rings lie at least half a grain apart, the sampling
// of a pattern without frequencies above 1/grain. They lie farther apart if the 2 pi r/grain grains on a ring
// still keep the energy between two rings within the margin. Planes lie half a depth of the grain apart, or
// as far as the cone of rays widens by law::kSteadyPlane such ring widths. Both steps grow as r^(3/2), so the
// number is bounded as margin^(-2/3): some thirty rings per plane at a margin of 1 %.
struct Grain {
  double across, f_number, margin;
  double steady(double radius) const {
    return margin * radius * std::sqrt(2 * std::numbers::pi * radius / across);
  }
  double ring_step(double radius) const { return std::max(0.5 * across, law::kSteadyRing * steady(radius)); }
  double plane_step(double radius) const {
    const double depth = 8 * across * f_number;
    return std::max(0.5 * depth, law::kSteadyPlane * 2 * f_number * steady(radius));
  }
};

std::vector<double> planes_between(const Groundwork& ground, const Grain& grain, std::vector<double> fitted) {
  std::sort(fitted.begin(), fitted.end());
  std::vector<double> planes = {fitted.front()};
  for (std::size_t k = 0; k + 1 < fitted.size(); ++k) {
    const double low = fitted[k], high = fitted[k + 1];
    const double radius = ground.mean_spot->encircled_energy_radius(0.3, 0.5 * (low + high));
    const double parts = std::ceil((high - low) / grain.plane_step(radius));
    for (int j = 1; j <= int(parts); ++j) planes.push_back(low + (high - low) * j / parts);
  }
  return planes;
}

// Guides from the innermost fitted fraction to the last but one; farther rings hold too many grains to vary.
std::vector<Target> guides_in(const MeanSpot& spot, const Grain& grain, double dz) {
  const double last = spot.encircled_energy_radius(*(std::end(law::kFittedShares) - 2));
  std::vector<Target> guides;
  for (double radius = spot.encircled_energy_radius(law::kFittedShares[0]); radius < last;
       radius += grain.ring_step(radius)) {
    Target guide;
    guide.statistic = RingThrough{radius, dz};
    guide.value = spot.encircled_energy(radius);
    guide.scale = std::max(radius * spot.encircled_energy_slope(radius), kFlattestCurve);
    guide.tolerance = law::kGuideShareOfMargin * grain.margin * guide.scale;
    guides.push_back(guide);
  }
  return guides;
}

}  // namespace

std::vector<Target> light_guides(const Task& task, const Groundwork& ground,
                                 const std::vector<double>& planes, int threads) {
  const double f_number = ground.focal_length / (2 * ground.radius);
  const Grain grain{task.wavelength * f_number, f_number, task.equivalence.margin};
  const std::vector<double> all = planes_between(ground, grain, planes);
  std::vector<std::vector<Target>> guides(all.size());
  parallel_for(all.size(), threads, [&](std::size_t k) {
    guides[k] = guides_in(ground.mean_spot->at_plane(all[k]), grain, all[k]);
  });
  std::vector<Target> flat;
  for (const std::vector<Target>& in_plane : guides)
    flat.insert(flat.end(), in_plane.begin(), in_plane.end());
  return flat;
}

}  // namespace aberfit::internal
