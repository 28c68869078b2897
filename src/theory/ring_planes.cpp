#include "ring_planes.h"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/root.h"

namespace aberfit::internal {
namespace {

constexpr int kEvenSteps = 16, kMostSteps = 200;  // steps of the first scan; reaches 1e6 first steps
constexpr double kNearlyMost = 0.9, kCloser = 0.125;
constexpr int kMostRoundsCloser = 12, kMostPeaks = 12;

struct Plane {
  double dz, share;
};

// The polynomial through `planes`, by Neville's scheme.
double interpolated(std::vector<Plane> planes, double dz) {
  for (std::size_t apart = 1; apart < planes.size(); ++apart)
    for (std::size_t i = 0; i + apart < planes.size(); ++i)
      planes[i].share = planes[i].share + (planes[i + 1].share - planes[i].share) * (dz - planes[i].dz) /
                                              (planes[i + apart].dz - planes[i].dz);
  return planes.front().share;
}

class Scan {
 public:
  explicit Scan(const std::function<double(double)>& energy) : energy_(energy) {}

  const Plane& operator[](std::size_t i) const { return planes_[i]; }
  std::size_t last() const { return planes_.size() - 1; }
  std::size_t top() const { return top_; }
  double most() const { return planes_[top_].share; }

  double add(double dz) {
    const Plane plane{dz, energy_(dz)};
    const auto where = std::upper_bound(planes_.begin(), planes_.end(), dz,
                                        [](double at, const Plane& other) { return at < other.dz; });
    planes_.insert(where, plane);
    top_ = std::size_t(std::max_element(planes_.begin(), planes_.end(),
                                        [](const Plane& a, const Plane& b) { return a.share < b.share; }) -
                       planes_.begin());
    return plane.share;
  }

  // The first plane on one side of the highest that holds less than `share`, or `last() + 1`.
  std::size_t below(double share, bool up) const {
    for (std::size_t i = top_;; up ? ++i : --i) {
      if (planes_[i].share < share) return i;
      if (i == (up ? last() : 0)) return last() + 1;
    }
  }

  // The highest point of the polynomial through the five planes about the highest one.
  Plane promised() const {
    const std::size_t from = top_ < 2 ? 0 : top_ - 2, to = std::min(last(), from + 4);
    const std::vector<Plane> near(planes_.begin() + std::ptrdiff_t(from),
                                  planes_.begin() + std::ptrdiff_t(to) + 1);
    const double left = planes_[top_ - 1].dz, right = planes_[top_ + 1].dz;
    constexpr int kLooks = 64;
    const auto at = [&](double k) { return left + (right - left) * k / kLooks; };
    int best = 1;
    for (int k = 2; k < kLooks; ++k)
      if (interpolated(near, at(k)) > interpolated(near, at(best))) best = k;
    // Minimises over the step number, which has no unit: the search ends within 1e-8 of a step.
    const auto [step, lack] = boost::math::tools::brent_find_minima(
        [&](double from_best) { return -interpolated(near, at(best + from_best)); }, -1.0, 1.0, 26);
    return {at(best + step), -lack};
  }

 private:
  const std::function<double(double)>& energy_;
  std::vector<Plane> planes_;  // ascending in dz
  std::size_t top_ = 0;
};

void look_outwards(const RingSearch& search, Scan* scan) {
  scan->add(0);
  for (const double side : {-1.0, 1.0}) {
    double dz = 0, share = scan->most();
    for (int k = 0; k < kMostSteps && share >= 0.5 * scan->most() && dz < search.furthest; ++k) {
      dz = std::min(dz + std::max(search.step, dz / kEvenSteps), search.furthest);
      share = scan->add(side * dz);
    }
  }
}

// Halves intervals next to planes that hold nearly the most, until they are short against the width.
void look_closer(Scan* scan) {
  for (int round = 0; round < kMostRoundsCloser; ++round) {
    const std::size_t lower = scan->below(0.5 * scan->most(), false),
                      upper = scan->below(0.5 * scan->most(), true);
    const double width =
        (*scan)[std::min(upper, scan->last())].dz - (*scan)[lower > scan->last() ? 0 : lower].dz;
    std::vector<double> between;
    for (std::size_t i = 0; i < scan->last(); ++i) {
      const Plane &a = (*scan)[i], &b = (*scan)[i + 1];
      if (std::max(a.share, b.share) >= kNearlyMost * scan->most() && b.dz - a.dz > kCloser * width)
        between.push_back(0.5 * (a.dz + b.dz));
    }
    if (between.empty()) return;
    for (const double dz : between) scan->add(dz);
  }
}

}  // namespace

GeneralisedHarveyShack::RingPlanes ring_halves(const std::function<double(double)>& energy,
                                               const RingSearch& search) {
  constexpr GeneralisedHarveyShack::RingPlanes kNone{kNaN, kNaN, kNaN};
  Scan scan(energy);
  look_outwards(search, &scan);
  look_closer(&scan);
  for (int round = 0; round < kMostPeaks; ++round) {
    if (scan.top() == 0 || scan.top() == scan.last()) return kNone;
    const Plane promised = scan.promised();
    if (!(promised.share > (1 + search.gain) * scan.most())) break;
    const double most = scan.most(), share = scan.add(promised.dz);
    if (std::abs(share - promised.share) <= search.gain * most) break;
  }
  const Plane peak = scan[scan.top()];
  const double half = 0.5 * peak.share;
  const auto crossing = [&](bool up) {
    const std::size_t outside = scan.below(half, up);
    if (outside > scan.last()) return kNaN;
    const Plane &out = scan[outside], &in = scan[up ? outside - 1 : outside + 1];
    return peak.dz + root_between([&](double from_peak) { return energy(peak.dz + from_peak) - half; },
                                  in.dz - peak.dz, out.dz - peak.dz, in.share - half, out.share - half,
                                  search.accuracy);
  };
  return {crossing(false), peak.dz, crossing(true)};
}

}  // namespace aberfit::internal
