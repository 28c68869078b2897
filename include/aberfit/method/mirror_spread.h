#pragma once
#include <string>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/method/task.h"
#include "aberfit/method/tost.h"

namespace aberfit {

struct Groundwork;
struct TargetSets;

/// How far mirrors of one specification differ in one judged statistic: one standard deviation.
struct StatisticSpread {
  std::string name;          ///< statistic_name
  double relative = kNaN;    ///< to what its differences are relative to, see EquivalenceMetric::difference
  double tolerances = kNaN;  ///< over the margin that it is judged by
};

/// "10 % in ee50_radius (10 tolerances)".
std::string spread_words(const StatisticSpread& spread);

/// How far mirrors of one specification differ in what is judged of them.
struct MirrorSpread {
  std::vector<StatisticSpread> statistics;  ///< those that there is a law for: light, then height and angles

  /// The one with the most tolerances; null where there is none.
  const StatisticSpread* worst() const;
  /// Sets EquivalenceMetric::spread of the metrics that are among them.
  void tell(std::vector<EquivalenceMetric>* metrics) const;
};

/// The spread of mirrors that are drawn from the whole roughness, by the law of light that also cuts the band
/// (RealisationSpread): an encircled energy is the light in its disc; a ring, a Strehl ratio and a transfer
/// function follow from light in a disc to first order; RMS height and scatter angles spread as their samples
/// over the aperture. That of `ground` where it has been laid out, else computed: some 20 ms a plane. A width
/// of a line spread and an RMS radius have no law and are left out. Empty without roughness, and where there
/// is no wave theory of the task.
MirrorSpread mirror_spread(const Task& task, const Groundwork& ground, const TargetSets& targets,
                           int threads);

}  // namespace aberfit
