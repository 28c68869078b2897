#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/method/task.h"

namespace aberfit::internal {

/// A statistic to fit; without a value, the theory gives it.
struct Wanted {
  Statistic statistic;
  std::optional<double> value = {};
  double standard_error = 0;
  double tolerance = 1e-3;  ///< absolute for an energy fraction, else relative to the value
  AskedAs asked = {};
};

/// Radius [m] in focus that holds a fraction of the energy.
using RingOf = std::function<double(double fraction)>;
/// The statistics of one entry of target.statistics, in its order. focal_sigma: of the theory's spot [m].
std::vector<Wanted> wanted_by(const StatisticRequest& request, const RingOf& ring_of, double focal_sigma);

}  // namespace aberfit::internal
