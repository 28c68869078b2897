#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/method/task.h"

namespace aberfit::internal {

/// A statistic to fit; without a value theory gives it.
struct Wanted {
  Statistic statistic;
  std::optional<double> value = {};
  double standard_error = 0;
  double tolerance = 1e-3;  ///< of a share of the light absolute, else relative to the value
};

/// Radius [m] in focus that holds a fraction of the light.
using RingOf = std::function<double(double fraction)>;
/// What one entry of target.statistics asks for, in its order. focal_sigma: of the theory's spot [m].
std::vector<Wanted> wanted_by(const StatisticRequest& request, const RingOf& ring_of, double focal_sigma);

/// Standard deviation [m] in each axis of a round Gaussian spot that has the value of this request, where it
/// has one that gives the spot a size. focal_length: [m].
std::optional<double> spot_sigma(const StatisticRequest& request, double focal_length);

}  // namespace aberfit::internal
