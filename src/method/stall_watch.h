#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "aberfit/fit/calibrate.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit::internal {

/// Ends a fit that stays above the tolerances.
class StallWatch {
 public:
  /// warm: the fit starts from where another ended, not from a draw.
  StallWatch(FocusModel model, int most_iterations, bool warm)
      : watches_pace_(model == FocusModel::kWaves),
        most_iterations_(most_iterations),
        fewest_(warm ? kPace + 1 : 2 * kPace) {}

  /// Of a fit that nothing else is tried for: 66 terms of a narrow band by waves rest where their pace says
  /// that they never arrive, and pass.
  static StallWatch patient() {
    StallWatch watch(FocusModel::kRays, 0, false);
    watch.patience_ = kPatient;
    return watch;
  }

  /// Asked after every iteration.
  bool stalled(const FitProgress& p) {
    if (watches_pace_) return out_of_reach(p);
    if (p.worst_mismatch < (1 - kWorthwhile) * best_) {
      best_ = p.worst_mismatch;
      since_ = p.iteration;
    }
    return best_ > kWellAbove && p.iteration - since_ >= patience_;
  }

 private:
  // Through waves an iteration costs as much as a whole fit of rays. The pace of the last iterations, which
  // only slackens, tells whether the rest of the way can be gone at all.
  bool out_of_reach(const FitProgress& p) {
    lowest_.push_back(lowest_.empty() ? p.worst_mismatch : std::min(lowest_.back(), p.worst_mismatch));
    if (lowest_.back() <= 1 || lowest_.size() <= fewest_) return false;
    const double gone = std::log(lowest_[lowest_.size() - 1 - kPace] / lowest_.back());
    return gone * (most_iterations_ - p.iteration) < kPace * std::log(lowest_.back());
  }

  // Fits that pass fell by more in every twelve iterations until they were at 2 tolerances (orders 2 to 31 of
  // fits/paper-physical); the ones that do not may run to the last iteration.
  static constexpr double kWorthwhile = 0.1, kWellAbove = 2;
  static constexpr int kPatience = 12, kPatient = 25;
  static constexpr std::size_t kPace = 5;
  bool watches_pace_;
  int patience_ = kPatience;
  int most_iterations_;
  std::size_t fewest_;  // a draw's first steps are not at its pace
  double best_ = std::numeric_limits<double>::infinity();
  int since_ = 0;
  std::vector<double> lowest_;
};

}  // namespace aberfit::internal
