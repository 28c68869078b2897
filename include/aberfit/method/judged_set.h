#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/task.h"
#include "aberfit/method/tost.h"

namespace aberfit {

/// Margin of a target, relative to its scale. It is less than that of the test where stray light is judged.
double margin_of(const Target& target, const EquivalenceSpec& asked);

/// The statistics needed to show a surface beside its targets and to judge it. It holds every target's own
/// statistic, followed by the judged ones that replace them (aim_of).
class JudgedSet {
 public:
  JudgedSet(const std::vector<Target>& fitted, const std::vector<Target>& held_out);

  const std::vector<Statistic>& statistics() const { return statistics_; }
  const std::vector<Target>& targets() const { return targets_; }  ///< fitted, then held out
  /// The shown value of each target, in its unit. values: values or errors in the order of `statistics()`.
  Eigen::VectorXd shown(const Eigen::VectorXd& values) const;
  /// The judged value of each target, in the unit of its aim. values: as above.
  Eigen::VectorXd judged(const Eigen::VectorXd& values) const;
  /// Ascending indices into `statistics()` of the shown and judged values of these targets.
  std::vector<Eigen::Index> places_of(const std::vector<std::size_t>& targets) const;
  /// Targets that are undecided or lack a value or an error. fresh: of `statistics()`; metrics: from `judge`.
  std::vector<std::size_t> open_targets(const FreshStatistics& fresh,
                                        const std::vector<EquivalenceMetric>& metrics) const;
  /// Adds `more`, one per target in the unit of its aim, to the judged entries of `values` (values or errors
  /// in the order of `statistics()`).
  void add_to_judged(const Eigen::VectorXd& more, Eigen::VectorXd* values) const;
  /// Two one-sided tests of every target. fresh: of `statistics()`.
  std::vector<EquivalenceMetric> judge(const FreshStatistics& fresh, const EquivalenceSpec& asked) const;

 private:
  std::vector<Target> targets_;
  std::size_t fitted_;
  std::vector<Statistic> statistics_;
  std::vector<Eigen::Index> judged_at_;
};

}  // namespace aberfit
