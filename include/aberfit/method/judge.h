#pragma once
#include <optional>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/prior_draws.h"

namespace aberfit {

/// The fitted surface judged by what its scene needs, where the fit's own theory or model is simpler;
/// absent where it is not. Theory: GHS, of half the heights in convention `paper`; given targets
/// stay themselves. Statistics: the fitted ones that exist for waves. Where that cannot be computed,
/// `undecided` and no metrics.
std::optional<NeededJudgement> judge_by_need(const Task& task, const Groundwork& ground,
                                             const TargetSets& targets, const TermSet& terms,
                                             const Eigen::VectorXd& coefficients, int threads,
                                             Warnings* warnings);

/// The predicted spread of ee90 between draws, and, where it is within a factor 2 of the margin (or above
/// half of it and the model is not that of the prediction), the one of 32 draws through `focus`.
Realisation realisation_of(const Task& task, const Groundwork& ground, const LightPath& focus,
                           const CoefficientPrior& prior, int threads);

/// Copies what `use` decided into the result.
void describe_models(const Groundwork& ground, const std::string& theory, FitOutcome* result);

/// A warning `surface-regime` where the fitted surface itself calls for another model than its
/// specification; nothing without a specification.
void warn_of_surface_regime(const Groundwork& ground, const SceneNumbers& surface, Warnings* warnings);

}  // namespace aberfit
