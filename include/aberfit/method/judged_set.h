#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/task.h"
#include "aberfit/method/tost.h"

namespace aberfit {

/// Margin that a target is judged by, relative to its scale: that of the test, or less where the light
/// outside an encircled energy's radius is judged, too.
double margin_of(const Target& target, const EquivalenceSpec& asked);

/// What has to be computed of a surface to show it beside its targets and to judge it, and the judging: every
/// target's own statistic, and behind them what is judged in its place (aim_of).
class JudgedSet {
 public:
  JudgedSet(const std::vector<Target>& fitted, const std::vector<Target>& held_out);

  const std::vector<Statistic>& statistics() const { return statistics_; }
  const std::vector<Target>& targets() const { return targets_; }  ///< fitted, then held out
  /// Of values (or errors) in the order of `statistics()`: what is shown, one per target, in its unit.
  Eigen::VectorXd shown(const Eigen::VectorXd& values) const;
  /// The same: what is judged, one per target, in the unit of its aim.
  Eigen::VectorXd judged(const Eigen::VectorXd& values) const;
  /// Where in `statistics()` these of the targets have what is shown and what is judged, ascending.
  std::vector<Eigen::Index> places_of(const std::vector<std::size_t>& targets) const;
  /// Targets without a value or an error, and those undecided. fresh: of `statistics()`; metrics: what
  /// `judge` makes of it.
  std::vector<std::size_t> open_targets(const FreshStatistics& fresh,
                                        const std::vector<EquivalenceMetric>& metrics) const;
  /// Adds to values (or errors) in the order of `statistics()`, to what is judged; more: one per target, in
  /// the unit of its aim.
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
