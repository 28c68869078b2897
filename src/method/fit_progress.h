#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/fit/calibrate.h"

namespace aberfit::internal {

/// Turns the progress of one fit into a line for people: set of terms, iteration, distance from the
/// tolerances, elapsed time and expected end.
class FitProgressLine {
 public:
  /// set: number of this set of terms, from 1; most: largest number of sets, 0 where unknown.
  explicit FitProgressLine(Eigen::Index terms, int set = 1, int most = 0, int start = 0);

  /// Returns the line after this iteration; to be called after each.
  std::string operator()(const FitProgress& p);

 private:
  std::string set_;
  FitProgress first_;  // of the current solve
};

/// Expected remaining time [s]: the time per iteration, times the iterations until the largest mismatch is 1
/// if it keeps falling by the same factor. NaN where it does not fall.
double seconds_left(const FitProgress& first, const FitProgress& last);

}  // namespace aberfit::internal
