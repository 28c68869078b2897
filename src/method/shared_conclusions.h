#pragma once
#include <string>

#include "aberfit/method/attempt.h"

// Conclusions for every surface judged by wave optics, fitted or measured.
namespace aberfit::internal {

/// Mismatch of the perfect mirror, and the warning `margin-sees-nothing` where it is within the margin.
void ask_perfect_mirror(const FitCase& of, FitOutcome* result);

/// Adds the spread of single mirrors of the specification to the result and to each of its metrics.
void tell_spread(const FitCase& of, FitOutcome* result);

/// The warning `realisation-spread`, where single mirrors differ by more than a tolerance. holds_for: the
/// subject of the verdict, a clause.
void warn_of_spread(const std::string& holds_for, FitOutcome* result);

/// The rest of a split roughness in the formats of other programs: table, ABg fits, PSD.
void tell_scatter_of_rest(const FitCase& of, FitOutcome* result);

}  // namespace aberfit::internal
