#pragma once
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/run_context.h"

namespace aberfit {

/// ee90 at z = f of `draws` seeded draws of the prior: their standard deviation over their mean. Draws
/// without an ee90 are left out; NaN with fewer than two, and where `context` was stopped.
double measured_spread(const LightPath& path, const CoefficientPrior& prior, std::uint64_t seed, int draws,
                       const RunContext& context);

/// Draws of the prior that zones are compared with.
inline constexpr std::size_t kZoneDraws = 1000;
/// Slope RMS per aperture zone (edges 0, .25, .5, .75, 1) over the overall one, of `coefficients` and of
/// draws from `prior`.
std::vector<ZoneSlope> zone_slopes(const Task& task, const TermSet& terms, const CoefficientPrior& prior,
                                   const Eigen::VectorXd& coefficients, int threads);

}  // namespace aberfit
