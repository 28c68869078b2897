#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "aberfit/method/frontier.h"

namespace aberfit {

/// A term bends single rays where there are fewer than this per term (1,593 terms overfit 37,000 rays).
inline constexpr std::int64_t kRaysPerTerm = 30;
/// What the gap between the fit's rays and fresh ones, and the sampling error of those, may take of the
/// margin of the verdict.
inline constexpr double kRayShareOfMargin = 0.5;
/// An `undecided` verdict asks for more rays until the sampling error is below this share of the margin.
inline constexpr double kDecidedShareOfMargin = 0.05;
/// Automatic fits take no more. On so many a set takes half a minute, and is judged on kMostFreshRays, as one
/// on twice as many would be.
inline constexpr std::int64_t kMostAutomaticRays = std::int64_t(1) << 20;

/// Rays that an automatic fit of so many terms starts with: a power of two, at least 16384 and kRaysPerTerm.
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
