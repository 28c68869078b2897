#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "aberfit/method/frontier.h"

namespace aberfit {

/// Rays that an automatic fit of this many terms starts with: a power of two, law::kRaysPerTerm per term,
/// between law::kFewestRays and law::kMostRays.
std::int64_t first_rays(Eigen::Index terms);
std::int64_t more_rays(std::int64_t rays);

/// The reason of a RayChoice whose gap is infinite.
inline constexpr const char* kNoValueToCompare =
    "a fitted statistic has no value on the points of the fit or of the judgement, so they cannot be "
    "compared";
/// Returns whether this many rays are enough for their verdict. True also where more rays are not available,
/// or would not help a statistic without a value. Fills `reason`.
bool explain_rays(std::int64_t rays, Verdict verdict, RayChoice* choice);
/// Returns whether this many grid cells are enough; fills `reason`. share: `allowed` as a fraction of the
/// margin.
bool explain_cells(Eigen::Index cells, double share, RayChoice* choice);

}  // namespace aberfit
