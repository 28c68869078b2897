#pragma once
#include <string>

#include "aberfit/method/attempt.h"

// What is said of every surface that light has judged, whether a fit made it or it was measured.
namespace aberfit::internal {

/// How far the perfect mirror would be from the targets, and the warning `margin-sees-nothing` where the
/// margin would let it pass.
void ask_perfect_mirror(const FitCase& of, FitOutcome* result);

/// How far mirrors of the specification differ, in the result and beside each of its metrics.
void tell_spread(const FitCase& of, FitOutcome* result);

/// The warning `realisation-spread`, where they differ by more than a tolerance. holds_for: what the verdict
/// is about, a clause.
void warn_of_spread(const std::string& holds_for, FitOutcome* result);

/// The rest of a split roughness, where there is any, as other programs take it: table, ABg fits, PSD.
void tell_scatter_of_rest(const FitCase& of, FitOutcome* result);

}  // namespace aberfit::internal
