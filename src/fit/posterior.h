#pragma once
#include "focus_residuals.h"

namespace aberfit::internal {

/// Fills the posterior fields of `result` from the residual Jacobian in white coordinates (targets,
/// guides and PSD bins x terms): covariance (I + J^T J)^-1 by way of the small matrix I + J J^T, so that cost
/// is linear in the number of terms.
void fill_posterior(const FitProblem& problem, const Jacobian& jacobian, FitResult* result);

}  // namespace aberfit::internal
