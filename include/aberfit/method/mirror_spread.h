#pragma once
#include <string>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/method/task.h"
#include "aberfit/method/tost.h"

namespace aberfit {

struct Groundwork;
struct TargetSets;

/// Spread of one judged statistic over mirrors of one specification: one standard deviation.
struct StatisticSpread {
  std::string name;          ///< statistic_name
  double relative = kNaN;    ///< in the scale of EquivalenceMetric::difference
  double tolerances = kNaN;  ///< over the margin of the statistic
};

/// "10 % in ee50_radius (10 tolerances)".
std::string spread_words(const StatisticSpread& spread);

/// Spread of the judged statistics over mirrors of one specification.
struct MirrorSpread {
  std::vector<StatisticSpread> statistics;  ///< statistics with a law: energies first, then height and angles

  /// The statistic with the most tolerances; null where there is none.
  const StatisticSpread* worst() const;
  /// Sets EquivalenceMetric::spread of the metrics that are among them.
  void tell(std::vector<EquivalenceMetric>* metrics) const;
};

/// Spread over mirrors drawn from the whole roughness, by the law that cuts the band (RealisationSpread). An
/// encircled energy is the energy in its disc; ring, Strehl ratio and transfer function follow from it to
/// first order. RMS height and scatter angles vary as their samples over the aperture. Uses the spread of
/// `ground` where present; else computes it, some 20 ms per plane. The width of a line spread and the RMS
/// radius have no law and are left out. Empty without roughness or without a wave theory.
MirrorSpread mirror_spread(const Task& task, const Groundwork& ground, const TargetSets& targets,
                           int threads);

}  // namespace aberfit
