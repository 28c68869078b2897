#pragma once
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/method/run_context.h"

namespace aberfit {

/// ee90 at z = f of `draws` seeded draws of the prior: their standard deviation over their mean. Draws
/// without an ee90 are left out; NaN with fewer than two, and where `context` was stopped.
double measured_spread(const LightPath& path, const CoefficientPrior& prior, std::uint64_t seed, int draws,
                       const RunContext& context);

}  // namespace aberfit
