#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace aberfit::internal {

/// The main peak of N(z) and its half crossings on either side, with derivatives for the next search.
struct RingCrossings {
  double lower, peak, upper;                               ///< [m], planes from z = f
  double slope_lower = 0, curvature = 0, slope_upper = 0;  ///< rough dN/dz [1/m], d2N/dz2 [1/m^2]; 0: unknown
};

struct RingSample {
  double dz, energy;
};

/// Zero of f between a and b, where its signs differ. It uses inverse interpolation through the last four
/// known values (Brent, Algorithms for Minimization without Derivatives, 1973, ch. 4, with one point more).
/// It bisects where that leaves the bracket or shrinks it too slowly. `known`: values elsewhere, the nearest
/// last. Every value of f costs transforms; this needs about five, a secant method nine.
template <typename F>
double interpolated_root(const F& f, std::vector<RingSample> known, RingSample a, RingSample b,
                         double tolerance) {
  constexpr std::size_t kPoints = 4;
  known.push_back(a);
  known.push_back(b);
  double last = std::abs(a.energy) < std::abs(b.energy) ? a.dz : b.dz, width = std::abs(b.dz - a.dz);
  for (int iteration = 0; iteration < 60 && a.energy != 0 && b.energy != 0; ++iteration) {
    const std::size_t count = std::min(kPoints, known.size());
    double next[kPoints];
    const RingSample* point = known.data() + (known.size() - count);
    for (std::size_t i = 0; i < count; ++i) next[i] = point[i].dz;
    for (std::size_t step = 1; step < count; ++step)  // Neville's scheme at f = 0
      for (std::size_t i = 0; i + step < count; ++i)
        next[i] = (point[i + step].energy * next[i] - point[i].energy * next[i + 1]) /
                  (point[i + step].energy - point[i].energy);
    double c = next[0];
    const bool slow = iteration % 4 == 3 && std::abs(b.dz - a.dz) > 0.25 * width;
    if (iteration % 4 == 3) width = std::abs(b.dz - a.dz);
    if (slow || !(c > std::min(a.dz, b.dz) && c < std::max(a.dz, b.dz))) c = 0.5 * (a.dz + b.dz);
    const double moved = std::abs(c - last);
    if (moved < tolerance && iteration > 0) return c;
    const RingSample at{c, f(c)};
    if (std::isnan(at.energy)) return c;
    ((at.energy > 0) == (a.energy > 0) ? a : b) = at;
    known.push_back(at);
    last = c;
    if (std::abs(b.dz - a.dz) < tolerance) break;
  }
  return std::abs(a.energy) < std::abs(b.energy) ? a.dz : b.dz;
}

/// A zero of f near `start`, by secants from a slope of the right sign, and the slope of the last secant. It
/// ends when the product of the last two steps, which is the order of a secant's error, is at most
/// tolerance^2; it takes that step without a further value of f. Returns nothing beyond `most` from the
/// start, or with NaN.
struct SecantRoot {
  double at, slope;
};
template <typename F>
std::optional<SecantRoot> secant_root(const F& f, double start, double slope, double tolerance, double most) {
  constexpr int kMostLooks = 8;
  double last = start, at_last = f(last), before = most;  // `before`: length of the step to `last`
  for (int look = 1; look < kMostLooks; ++look) {
    const double next = last - at_last / slope;
    if (!(std::abs(next - start) <= most)) return std::nullopt;
    const double step = std::abs(next - last);
    if (step * std::min(before, most) <= tolerance * tolerance) return SecantRoot{next, slope};
    const double at_next = f(next), steeper = (at_next - at_last) / (next - last);
    if (!std::isfinite(at_next) || !(steeper * slope > 0)) return std::nullopt;
    before = step;
    last = next;
    at_last = at_next;
    slope = steeper;
  }
  return std::nullopt;
}

/// Follows the crossings of a similar surface or grid, `guess`, by secants instead of a scan. Returns nothing
/// if they moved by more than half of `step`, or with NaN.
template <typename Energy, typename Slope>
std::optional<RingCrossings> follow_ring(const Energy& energy, const Slope& slope, const RingCrossings& guess,
                                         double step) {
  // These are in steps, far below the resolution of a fit or the difference of two grids. The energy at the
  // peak has a quadratic error in the peak's position.
  constexpr double kTolerance = 1e-4, kPeakTolerance = 3e-3, kMost = 0.5;
  const auto not_zero = [](double known, double otherwise) { return known != 0 ? known : otherwise; };
  // The first curvature comes from a parabola through the peak and both crossings.
  const double half_width = 0.5 * (guess.upper - guess.lower), at_guess = energy(guess.peak);
  const std::optional<SecantRoot> peak =
      secant_root(slope, guess.peak, not_zero(guess.curvature, -at_guess / (half_width * half_width)),
                  kPeakTolerance * step, kMost * step);
  if (!peak) return std::nullopt;
  const double half = 0.5 * energy(peak->at);
  const auto excess = [&](double z) { return energy(z) - half; };
  // The first slope assumes that N falls from twice `half` to `half` between the peak and here.
  const auto crossing = [&](double start, double known) {
    return secant_root(excess, start, not_zero(known, -half / (1.5 * (start - peak->at))), kTolerance * step,
                       kMost * step);
  };
  const auto upper = crossing(guess.upper, guess.slope_upper),
             lower = crossing(guess.lower, guess.slope_lower);
  if (!upper || !lower || !(lower->at < peak->at && peak->at < upper->at)) return std::nullopt;
  return RingCrossings{lower->at, peak->at, upper->at, lower->slope, peak->slope, upper->slope};
}

/// Crossings nearest to the highest peak of `energy(dz)`, whose derivative is `slope(dz)`. A scan in steps of
/// `step` is widened until both ends lie below half. Returns nothing when N does not fall to half within 60
/// steps, or when `energy` gives NaN.
template <typename Energy, typename Slope>
std::optional<RingCrossings> search_ring(const Energy& energy, const Slope& slope, double step) {
  constexpr int kMostPlanes = 60;  // on either side
  // Tolerances in steps. The error of the width is quadratic in that of the peak's position; the error of its
  // gradient is linear.
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

  // N falls from the highest sample to its neighbour even if it rises at first, so a maximum lies between. We
  // halve the interval until the slopes at both ends bracket it.
  double peak = scan[top].dz;
  if (const double at_inner = slope(peak); at_inner != 0) {
    const double inner = peak, span = scan[top + 1].dz - scan[top - 1].dz;
    double outer = at_inner > 0 ? scan[top + 1].dz : scan[top - 1].dz, at_outer = slope(outer);
    for (int tries = 0; tries < 40 && (at_outer > 0) == (at_inner > 0); ++tries) {
      outer = 0.5 * (inner + outer);
      at_outer = slope(outer);
    }
    if ((at_outer > 0) == (at_inner > 0)) return std::nullopt;
    peak = interpolated_root(slope, {}, {inner, at_inner}, {outer, at_outer}, kPeakTolerance * span);
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
    std::vector<RingSample> known;  // one on either side of the bracket
    if (k > 1 && k + 2 < scan.size())
      for (const std::size_t beyond : {outward > 0 ? k - 2 : k + 2, outward > 0 ? k + 1 : k - 1})
        known.push_back({scan[beyond].dz, scan[beyond].energy - half});
    return interpolated_root(excess, known, {inside.dz, inside.energy - half},
                             {outside.dz, outside.energy - half}, kCrossingTolerance * step);
  };
  const auto upper = crossing(+1), lower = crossing(-1);
  if (!upper || !lower) return std::nullopt;
  return RingCrossings{.lower = *lower, .peak = peak, .upper = *upper};
}

}  // namespace aberfit::internal
