#include "diffraction_ring.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace aberfit {
namespace {

constexpr int kMostPlanes = 60;  // of the scan, on either side
// In steps of the scan. The width changes with the square of an error of the peak, its gradient in
// proportion.
constexpr double kCrossingTolerance = 1e-12, kPeakTolerance = 1e-10;

struct Sample {
  double dz, energy;
};

// N(z); NaN where the plane does not exist or the ring leaves the field of view.
class RingEnergy {
 public:
  RingEnergy(const DiffractionScene& scene, DiffractionPlane* plane, double ring)
      : scene_(scene), plane_(*plane), ring_(ring) {}

  double operator()(double dz) {
    if (!scene_.has_plane(dz) || ring_ > scene_.largest_radius(dz)) return std::nan("");
    plane_.focus(dz);
    return plane_.energy(ring_);
  }
  double slope(double dz) {
    plane_.focus(dz);
    return plane_.energy_slope(ring_, plane_.energy_gradient(ring_));
  }

 private:
  const DiffractionScene& scene_;
  DiffractionPlane& plane_;
  double ring_;
};

// Zero of f between a and b, where its signs differ: regula falsi, Illinois variant.
template <typename F>
double root(const F& f, double a, double fa, double b, double fb, double tolerance) {
  for (int iteration = 0; iteration < 60 && fa != 0 && fb != 0 && std::abs(b - a) > tolerance; ++iteration) {
    double c = (fa * b - fb * a) / (fa - fb);
    if (!(c > std::min(a, b) && c < std::max(a, b))) c = 0.5 * (a + b);
    const double fc = f(c);
    const double moved = std::abs(c - b);
    if ((fc > 0) == (fb > 0)) {
      fa *= 0.5;
    } else {
      a = b;
      fa = fb;
    }
    b = c;
    fb = fc;
    if (moved < tolerance) break;
  }
  return fb == 0 || std::abs(fb) < std::abs(fa) ? b : a;
}

// The highest point between the neighbours of the highest sample.
std::optional<double> peak_between(RingEnergy& energy, const Sample& before, const Sample& top,
                                   const Sample& after) {
  const double slope = energy.slope(top.dz);
  if (slope == 0) return top.dz;
  const auto slope_at = [&](double z) { return energy.slope(z); };
  double inner = top.dz, at_inner = slope, outer = slope > 0 ? after.dz : before.dz;
  // Energy falls from the inner end to the outer one although it starts upwards: a maximum lies between.
  // Halve until the slopes at both ends bracket it.
  for (int tries = 0; tries < 40; ++tries) {
    const double at_outer = energy.slope(outer);
    if ((at_outer > 0) != (slope > 0))
      return root(slope_at, inner, at_inner, outer, at_outer, kPeakTolerance * (after.dz - before.dz));
    outer = 0.5 * (inner + outer);
  }
  return std::nullopt;
}

}  // namespace

std::optional<DiffractionRingWidth> diffraction_ring_width(const DiffractionScene& scene,
                                                           DiffractionPlane* plane, double ring,
                                                           Eigen::ArrayXd* d_phase, double* d_ring) {
  if (!(ring > 0)) return std::nullopt;
  RingEnergy energy(scene, plane, ring);
  // A perfect disc of light of RMS radius rho is half inside the ring at dz = f ring/rho; rays of a rough
  // mirror spread the profile about twice as far. Five steps of a quarter hold either, more are added as
  // needed.
  const PupilSample& sample = scene.problem().pupil.sample;
  const double rho = std::sqrt((sample.weight * (sample.x.square() + sample.y.square())).sum());
  if (!(rho > 0)) return std::nullopt;
  const double step = 0.25 * scene.problem().focal_length * ring / rho;
  std::vector<Sample> up{{0.0, energy(0.0)}}, down;
  if (!std::isfinite(up[0].energy)) return std::nullopt;
  double highest = up[0].energy;
  const auto extend = [&](std::vector<Sample>* side, double dz) {
    const double value = energy(dz);
    side->push_back({dz, value});
    if (value > highest) highest = value;
    return std::isfinite(value);
  };
  for (int k = 1; k <= 3; ++k)
    if (!extend(&up, k * step) || !extend(&down, -k * step)) return std::nullopt;
  for (int k = 4;
       k <= kMostPlanes && (up.back().energy >= 0.5 * highest || down.back().energy >= 0.5 * highest); ++k) {
    if (up.back().energy >= 0.5 * highest && !extend(&up, up.back().dz + step)) return std::nullopt;
    if (down.back().energy >= 0.5 * highest && !extend(&down, down.back().dz - step)) return std::nullopt;
  }
  std::vector<Sample> scan(down.rbegin(), down.rend());
  scan.insert(scan.end(), up.begin(), up.end());
  std::size_t top = 0;
  for (std::size_t k = 0; k < scan.size(); ++k)
    if (scan[k].energy > scan[top].energy) top = k;
  if (top == 0 || top + 1 == scan.size()) return std::nullopt;
  const auto peak = peak_between(energy, scan[top - 1], scan[top], scan[top + 1]);
  if (!peak) return std::nullopt;
  const double half = 0.5 * energy(*peak);
  const auto excess = [&](double z) { return energy(z) - half; };
  const auto crossing = [&](int outward) -> std::optional<double> {
    std::size_t k = top;
    while (scan[k].energy >= half) {
      if (k == 0 || k + 1 == scan.size()) return std::nullopt;
      k = outward > 0 ? k + 1 : k - 1;
    }
    const Sample& outside = scan[k];
    const Sample& inside = scan[outward > 0 ? k - 1 : k + 1];
    return root(excess, inside.dz, inside.energy - half, outside.dz, outside.energy - half,
                kCrossingTolerance * step);
  };
  const auto upper = crossing(+1), lower = crossing(-1);
  if (!upper || !lower) return std::nullopt;
  const DiffractionRingWidth result{*upper - *lower, *peak, *lower, *upper};
  if (!d_phase) return result;
  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; the peak does not move N(peak) to first
  // order.
  struct End {
    double density, slope;
    Eigen::ArrayXd gradient;
  };
  const auto end_at = [&](double z) {
    plane->focus(z);
    End end{plane->density(ring), 0.0, plane->energy_gradient(ring)};
    end.slope = plane->energy_slope(ring, end.gradient);
    return end;
  };
  const End at_upper = end_at(*upper), at_lower = end_at(*lower), at_peak = end_at(*peak);
  if (at_upper.slope == 0 || at_lower.slope == 0) return std::nullopt;
  const double for_upper = -1 / at_upper.slope, for_lower = 1 / at_lower.slope;
  const double for_peak = -0.5 * (for_upper + for_lower);
  *d_phase = for_upper * at_upper.gradient + for_lower * at_lower.gradient + for_peak * at_peak.gradient;
  *d_ring = for_upper * at_upper.density + for_lower * at_lower.density + for_peak * at_peak.density;
  return result;
}

}  // namespace aberfit
