#pragma once
#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

/// Draws of the prior that zones are compared with.
inline constexpr std::size_t kZoneDraws = 1000;
/// Slope RMS per aperture zone (edges 0, .25, .5, .75, 1) over the overall one, of `coefficients` and of
/// draws from `prior`.
std::vector<ZoneSlope> zone_slopes(const Task& task, const TermSet& terms, const CoefficientPrior& prior,
                                   const Eigen::VectorXd& coefficients, int threads);

}  // namespace aberfit
