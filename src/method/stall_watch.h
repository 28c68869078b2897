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
  bool stalled(const FitProgress& p) {
    if (p.solve != solve_) {  // of another smoothing, whose mismatch begins anew
      solve_ = p.solve;
      far_.best = near_.best = std::numeric_limits<double>::infinity();
    }
    return (by_waves_ && out_of_reach(p)) || rests(p);
  }

 private:
  struct Rest {
    double worthwhile, above;  // share of the mismatch; tolerances at which it ends to count
    double best = std::numeric_limits<double>::infinity();
    int since = 0;

    bool lasts(const FitProgress& p, int patience) {
      if (p.worst_mismatch < (1 - worthwhile) * best || (best > above && p.worst_mismatch <= above)) {
        best = p.worst_mismatch;
        since = p.iteration;
      }
      return best > above && p.iteration - since >= patience;
    }
  };
  bool rests(const FitProgress& p) {
    const bool near = !by_waves_ && near_.lasts(p, patience_);
    return far_.lasts(p, patience_) || near;
  }

  // Through waves an iteration costs as much as a whole fit of rays. The pace of the last iterations, which
  // only slackens, tells whether the rest of the way can be gone at all.
  bool out_of_reach(const FitProgress& p) {
    lowest_.push_back(lowest_.empty() ? p.worst_mismatch : std::min(lowest_.back(), p.worst_mismatch));
    if (lowest_.back() <= within_ || lowest_.size() <= fewest_) return false;
    const double gone = std::log(lowest_[lowest_.size() - 1 - pace_] / lowest_.back());
    return gone * (most_iterations_ - p.iteration) < double(pace_) * std::log(lowest_.back() / within_);
  }

  // Fits that pass fell by a tenth in every twelve iterations until they were at 2 tolerances (orders 2 to 31
  // of fits/paper-physical). By rays few of those below that rest and pass: of 1018 fits of 54 scenes of the
  // matrix 357 of 363 that met their tolerances fell by a hundredth in every twelve; ending there saves a
  // fifth of the time of all.
  Rest far_{0.1, 2}, near_{0.01, 1};
  static constexpr int kPatience = 12, kPatient = 25;
  static constexpr std::size_t kPace = 5, kFarPace = 8;
  bool by_waves_;
  int patience_;  // iterations that may bring nothing
  int most_iterations_;
  double within_;             // tolerances that the pace has to reach
  std::size_t pace_ = kPace;  // iterations that tell it
  std::size_t fewest_;        // a draw's first steps are not at its pace
  std::vector<double> lowest_;
  int solve_ = 0;
};

}  // namespace aberfit::internal
