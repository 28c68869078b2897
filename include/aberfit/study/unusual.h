#pragma once
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// Code of the warning; `screen` gives the same code to measurements.
inline constexpr const char* kUnusual = "unusual";

/// A number of a study that is legal, but outside the range of what anybody builds or measures.
struct UnusualNumber {
  std::string pointer;   ///< JSON pointer of the number that is probably wrong
  std::string value;     ///< the number itself with its unit, "400 m"
  std::string quantity;  ///< the quantity that it takes out of range, "an f-number of 0.007"
  std::string ordinary;  ///< ordinary range, "0.25 to 5000"
  /// A sentence that names the slip that would explain it: another unit, or focal length and diameter
  /// swapped. If no slip does, it says what to check.
  std::string meant;
  bool too_small = false;  ///< the quantity is below that range
};

/// The numbers of `study` that are probably wrong; none if all quantities are in the ordinary ranges
/// (`unusual.cpp`). It tries the usual slips: powers of 1000 between the unit meant and the
/// unit read, and focal length and diameter swapped. A slip is named if undoing it brings every quantity into
/// its range. If several slips explain an f-number, those that give the more common mirror are named.
/// Precondition: the PSDs of the study are usable (psd_problem is empty), which read_study ensures.
std::vector<UnusualNumber> unusual_numbers(const Study& study);

/// The same numbers as warnings `unusual`, one line each. read_study adds them to `data_warnings`.
Warnings unusual_warnings(const Study& study);

}  // namespace aberfit
