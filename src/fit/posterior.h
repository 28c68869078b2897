#pragma once
#include "focus_residuals.h"

namespace aberfit::internal {

/// Fills the posterior fields of `result` from the residual Jacobian in white coordinates (targets, guides
/// and PSD bins x terms). The covariance (I + J^T J)^-1 uses I + J J^T, at a cost linear in the terms.
void fill_posterior(const FitProblem& problem, const Jacobian& jacobian, FitResult* result);

}  // namespace aberfit::internal
