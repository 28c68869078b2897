#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace aberfit::internal {

/// The main peak of N(z) and where N falls to half of it on either side.
struct RingCrossings {
  double lower, peak, upper;  ///< [m], planes from z = f
};

struct RingSample {
  double dz, energy;
};

/// Zero of f between a and b, where its signs differ: regula falsi, Illinois variant.
template <typename F>
double illinois_root(const F& f, double a, double fa, double b, double fb, double tolerance) {
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

/// Crossings nearest to the highest peak of `energy(dz)`, of which `slope(dz)` is the derivative, from a scan
/// in steps of `step` that is widened until both ends lie below half. NaN from `energy` ends the search:
/// nothing, as where N does not fall to half within 60 steps.
template <typename Energy, typename Slope>
std::optional<RingCrossings> search_ring(const Energy& energy, const Slope& slope, double step) {
  constexpr int kMostPlanes = 60;  // on either side
  // In steps. The width changes with the square of an error of the peak, its gradient in proportion.
  constexpr double kCrossingTolerance = 1e-12, kPeakTolerance = 1e-10;
  std::vector<RingSample> up{{0.0, energy(0.0)}}, down;
  double highest = up[0].energy;
  if (!std::isfinite(highest)) return std::nullopt;
  const auto extend = [&](std::vector<RingSample>* side, double dz) {
    const double value = energy(dz);
    side->push_back({dz, value});
    highest = std::max(highest, value);
    return std::isfinite(value);
  };
  for (int k = 1; k <= 3; ++k)
    if (!extend(&up, k * step) || !extend(&down, -k * step)) return std::nullopt;
  for (int k = 4;
       k <= kMostPlanes && (up.back().energy >= 0.5 * highest || down.back().energy >= 0.5 * highest); ++k) {
    if (up.back().energy >= 0.5 * highest && !extend(&up, up.back().dz + step)) return std::nullopt;
    if (down.back().energy >= 0.5 * highest && !extend(&down, down.back().dz - step)) return std::nullopt;
  }
  std::vector<RingSample> scan(down.rbegin(), down.rend());
  scan.insert(scan.end(), up.begin(), up.end());
  std::size_t top = 0;
  for (std::size_t k = 0; k < scan.size(); ++k)
    if (scan[k].energy > scan[top].energy) top = k;
  if (top == 0 || top + 1 == scan.size()) return std::nullopt;

  // Energy falls from the highest sample to its neighbour although it may start upwards: a maximum lies
  // between. Halve until the slopes at both ends bracket it.
  double peak = scan[top].dz;
  if (const double at_inner = slope(peak); at_inner != 0) {
    const double inner = peak, span = scan[top + 1].dz - scan[top - 1].dz;
    double outer = at_inner > 0 ? scan[top + 1].dz : scan[top - 1].dz, at_outer = slope(outer);
    for (int tries = 0; tries < 40 && (at_outer > 0) == (at_inner > 0); ++tries) {
      outer = 0.5 * (inner + outer);
      at_outer = slope(outer);
    }
    if ((at_outer > 0) == (at_inner > 0)) return std::nullopt;
    peak = illinois_root(slope, inner, at_inner, outer, at_outer, kPeakTolerance * span);
  }
  const double half = 0.5 * energy(peak);
  const auto excess = [&](double z) { return energy(z) - half; };
  const auto crossing = [&](int outward) -> std::optional<double> {
    std::size_t k = top;
    while (scan[k].energy >= half) {
      if (k == 0 || k + 1 == scan.size()) return std::nullopt;
      k = outward > 0 ? k + 1 : k - 1;
    }
    const RingSample& outside = scan[k];
    const RingSample& inside = scan[outward > 0 ? k - 1 : k + 1];
    return illinois_root(excess, inside.dz, inside.energy - half, outside.dz, outside.energy - half,
                         kCrossingTolerance * step);
  };
  const auto upper = crossing(+1), lower = crossing(-1);
  if (!upper || !lower) return std::nullopt;
  return RingCrossings{*lower, peak, *upper};
}

}  // namespace aberfit::internal
