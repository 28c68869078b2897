#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/fit/calibrate.h"

namespace aberfit::internal {

/// Turns the progress of one fit into the line that people read: the set of terms, the iteration, how far it
/// is from its tolerances, the time so far and when it is likely to end.
class FitProgressLine {
 public:
  /// set: which set of terms this is, from 1; most: how many are tried at most, 0 where that is not known.
  explicit FitProgressLine(Eigen::Index terms, int set = 1, int most = 0, int start = 0);

  /// The line of the fit after this iteration; to be called after each.
  std::string operator()(const FitProgress& p);

 private:
  std::string set_;
  FitProgress first_;  // of the solve that is under way
};

/// Seconds from the first to the last progress over the iterations between, times those that are left until
/// the largest mismatch is 1 where it goes on to fall by the same factor in each. NaN where it does not fall.
double seconds_left(const FitProgress& first, const FitProgress& last);

}  // namespace aberfit::internal
