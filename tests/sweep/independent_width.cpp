#include "independent_width.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace aberfit {
namespace {

constexpr int kPerWidth = 6, kReach = kPerWidth, kFarthest = 2 * kPerWidth;
constexpr double kClose = 1e-4;  // of the width

class SampledCurve {
 public:
  SampledCurve(const std::function<double(double)>& curve, double step) : curve_(curve), step_(step) {}
  double at(int k) {
    const auto known = known_.find(k);
    return known != known_.end() ? known->second : known_[k] = curve_(k * step_);
  }
  double between(double z) const { return curve_(z); }
  double step() const { return step_; }

 private:
  const std::function<double(double)>& curve_;
  double step_;
  std::map<int, double> known_;
};

struct Point {
  double z, value;
};

// Vertex of the parabola through three points.
double vertex(const Point& a, const Point& b, const Point& c) {
  const double to_a = b.z - a.z, to_c = b.z - c.z, up_c = to_a * (b.value - c.value),
               up_a = to_c * (b.value - a.value);
  return up_c == up_a ? b.z : b.z - 0.5 * (to_a * up_c - to_c * up_a) / (up_c - up_a);
}

Point highest(SampledCurve* curve, int k) {
  const double step = curve->step();
  Point low{(k - 1) * step, curve->at(k - 1)}, top{k * step, curve->at(k)},
      high{(k + 1) * step, curve->at(k + 1)};
  for (int look = 0; look < 2; ++look) {
    const double z = vertex(low, top, high);
    if (!(z > low.z && z < high.z) || std::abs(z - top.z) < kClose * step) break;
    const Point found{z, curve->between(z)};
    const bool on_the_left = found.z < top.z;
    if (found.value < top.value) {
      (on_the_left ? low : high) = found;
      continue;
    }
    (on_the_left ? high : low) = top;
    top = found;
  }
  return top;
}

struct Crossing {
  double z, slope;
};

// Crossing of `half` from above, searched from sample `k`, which is above it, in steps of `by`.
std::optional<Crossing> falls_to(double half, SampledCurve* curve, int k, int by) {
  while (curve->at(k + by) > half)
    if (std::abs(k += by) >= kFarthest) return std::nullopt;
  const double step = curve->step();
  Point above{k * step, curve->at(k) - half}, below{(k + by) * step, curve->at(k + by) - half};
  const double steepness = std::abs(above.value - below.value) / step;
  Crossing found{below.z, steepness};
  double held_above = above.value, held_below = below.value;  // Illinois' halves against a lazy end
  for (int look = 0; look < 12; ++look) {
    const double z = above.z + (below.z - above.z) * held_above / (held_above - held_below);
    const bool settled = std::abs(z - found.z) < kClose * kPerWidth * step;
    found.z = z;
    if (settled) break;
    const Point here{z, curve->between(z) - half};
    if (here.value > 0) {
      above = here, held_above = here.value, held_below *= 0.5;
    } else {
      below = here, held_below = here.value, held_above *= 0.5;
    }
  }
  return found;
}

}  // namespace

std::optional<IndependentWidth> independent_width(const std::function<double(double)>& curve,
                                                  double expected) {
  SampledCurve samples(curve, expected / kPerWidth);
  int best = 0;
  for (int reach = kReach; reach <= kFarthest; ++reach) {
    for (int k = -reach; k <= reach; ++k)
      if (samples.at(k) > samples.at(best)) best = k;
    if (std::abs(best) < reach) break;
  }
  if (std::abs(best) >= kFarthest) return std::nullopt;
  const Point peak = highest(&samples, best);
  const double half = 0.5 * peak.value;
  if (!(half > 0)) return std::nullopt;
  const std::optional<Crossing> upper = falls_to(half, &samples, best, 1),
                                lower = falls_to(half, &samples, best, -1);
  if (!upper || !lower) return std::nullopt;
  // The half level is wrong by half of the error of the peak, at worst in the opposite direction.
  return IndependentWidth{upper->z - lower->z, 1.5 * (1 / upper->slope + 1 / lower->slope)};
}

}  // namespace aberfit
