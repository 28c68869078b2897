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
  static constexpr double kFar = 10;  ///< tolerances from which what has ended has nothing to hope for

  /// warm: the fit starts from where another ended, not from a draw. within: the tolerances that it ends at.
  StallWatch(FocusModel model, int most_iterations, bool warm, double within = 1)
      : by_waves_(model == FocusModel::kWaves),
        patience_(by_waves_ ? std::numeric_limits<int>::max() : kPatience),
        most_iterations_(most_iterations),
        within_(within),
        fewest_(warm ? kPace + 1 : 2 * kPace) {}

  /// Of a fit that nothing else is tried for: 66 terms of a narrow band by waves rest where their pace says
  /// that they never arrive, and pass. Far away the pace is asked nevertheless: terms that cannot carry a
  /// deep spot near by 1 % an iteration, of seven seconds, at 279 tolerances.
  static StallWatch patient(FocusModel model, int most_iterations) {
    StallWatch watch(model, most_iterations, false, kFar);
    watch.patience_ = kPatient;
    watch.pace_ = kFarPace;
    watch.fewest_ = kPatience;
    return watch;
  }

  /// Asked after every iteration.
  bool stalled(const FitProgress& p) { return (by_waves_ && out_of_reach(p)) || rests(p); }

 private:
  bool rests(const FitProgress& p) {
    if (p.worst_mismatch < (1 - kWorthwhile) * best_) {
      best_ = p.worst_mismatch;
      since_ = p.iteration;
    }
    return best_ > kWellAbove && p.iteration - since_ >= patience_;
  }

  // Through waves an iteration costs as much as a whole fit of rays. The pace of the last iterations, which
  // only slackens, tells whether the rest of the way can be gone at all.
  bool out_of_reach(const FitProgress& p) {
    lowest_.push_back(lowest_.empty() ? p.worst_mismatch : std::min(lowest_.back(), p.worst_mismatch));
    if (lowest_.back() <= within_ || lowest_.size() <= fewest_) return false;
    const double gone = std::log(lowest_[lowest_.size() - 1 - pace_] / lowest_.back());
    return gone * (most_iterations_ - p.iteration) < double(pace_) * std::log(lowest_.back() / within_);
  }

  // Fits that pass fell by more in every twelve iterations until they were at 2 tolerances (orders 2 to 31 of
  // fits/paper-physical); the ones that do not may run to the last iteration.
  static constexpr double kWorthwhile = 0.1, kWellAbove = 2;
  static constexpr int kPatience = 12, kPatient = 25;
  static constexpr std::size_t kPace = 5, kFarPace = 8;
  bool by_waves_;
  int patience_;  // iterations that may bring nothing
  int most_iterations_;
  double within_;             // tolerances that the pace has to reach
  std::size_t pace_ = kPace;  // iterations that tell it
  std::size_t fewest_;        // a draw's first steps are not at its pace
  double best_ = std::numeric_limits<double>::infinity();
  int since_ = 0;
  std::vector<double> lowest_;
};

}  // namespace aberfit::internal
