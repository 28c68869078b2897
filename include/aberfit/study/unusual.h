#pragma once
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// Code of the warning; `screen` says it of measurements.
inline constexpr const char* kUnusual = "unusual";

/// A number of a study that is legal, but outside of what anybody builds or measures.
struct UnusualNumber {
  std::string pointer;   ///< JSON pointer of the number that is probably wrong
  std::string value;     ///< the number itself with its unit, "400 m"
  std::string quantity;  ///< what is out of its ordinary range because of it, "an f-number of 0.007"
  std::string ordinary;  ///< that range, "0.25 to 5000"
  /// Which slip would explain it, as a sentence: another unit, or focal length and diameter swapped; where
  /// none would, what to check.
  std::string meant;
  bool too_small = false;  ///< the quantity is below that range
};

/// The numbers of `study` that can hardly be meant, one entry for each number that is probably wrong; none
/// for a study whose quantities are all in the ordinary ranges (`unusual.cpp`). A slip is
/// looked for among the usual ones: powers of 1000 between the unit meant and the unit read, and focal length
/// and diameter swapped. It is named if every quantity is in its range once it is undone. Of several that
/// explain an f-number those are named that make the more common mirror.
/// Precondition: the PSDs of the study are usable (psd_problem is empty), as read_study has made sure.
std::vector<UnusualNumber> unusual_numbers(const Study& study);

/// The same as warnings `unusual`, one line each. read_study puts them into `data_warnings`.
Warnings unusual_warnings(const Study& study);

}  // namespace aberfit
