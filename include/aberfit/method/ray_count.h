#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "aberfit/method/frontier.h"

namespace aberfit {

/// Rays that an automatic fit of so many terms starts with: a power of two, law::kRaysPerTerm a
/// term, at least law::kFewestRays and at most law::kMostRays.
std::int64_t first_rays(Eigen::Index terms);
std::int64_t more_rays(std::int64_t rays);

/// The reason of a RayChoice whose gap is infinite.
inline constexpr const char* kNoValueToCompare =
    "a fitted statistic has no value on the sample of the fit or on the one that judges: nothing to compare";
/// Whether so many rays are enough for the verdict they gave (or no more can be had, or would not help what
/// has no value); fills `reason`.
bool explain_rays(std::int64_t rays, Verdict verdict, RayChoice* choice);
/// Whether so many cells are enough for a fit by waves; fills `reason`. share: of the margin, that `allowed`
/// is.
bool explain_cells(Eigen::Index cells, double share, RayChoice* choice);

}  // namespace aberfit
