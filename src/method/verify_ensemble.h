#pragma once
#include <string>
#include <vector>

#include "aberfit/method/constants.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/verify.h"

namespace aberfit::internal {

/// Statistics of the mean irradiance of an ensemble, in the requested order, and their standard errors [SI].
struct EnsembleMean {
  Eigen::VectorXd value, standard_error;
};

/// The realisations of an ensemble: `draws` (a multiple of law::kGroups) random surfaces of `prior`.
struct Ensemble {
  const Task& task;
  const TermSet& terms;
  const CoefficientPrior& prior;
  int draws = 0;
  const RunContext& context;  ///< asked before each surface
};

/// Statistics of all rays together, each realisation on a fresh pupil of a few thousand Sobol points per
/// group.
EnsembleMean ensemble_by_rays(const Ensemble& ensemble, const std::vector<Statistic>& statistics);
/// Statistics of as many perturbed rays (Harvey-Shack), with `slope` per axis.
EnsembleMean ensemble_of_perturbed_rays(const Task& task, double slope, int draws,
                                        const std::vector<Statistic>& statistics, int threads);

/// Fills the wave-optics part of the report: GHS of the equivalent surface against the diffraction of the
/// realisations or of `given`. It covers those of `statistics` that wave optics has: EE radii, and the width
/// of the ring that holds 90 % in theory.
void compare_in_light(const Ensemble& ensemble, const Groundwork& ground,
                      const std::optional<GivenSurface>& given, const std::vector<Statistic>& statistics,
                      VerifyReport* report);

/// Degrees of freedom of a standard error from groups of realisations.
inline constexpr double kGroupFreedom = law::kGroups - 1;

}  // namespace aberfit::internal
