#pragma once
#include <string>
#include <vector>

#include "aberfit/method/plan.h"
#include "aberfit/method/verify.h"

namespace aberfit::internal {

/// Statistics of the mean light of an ensemble, in the order asked, and their standard errors [SI].
struct EnsembleMean {
  Eigen::VectorXd value, standard_error;
};

/// Where the draws of an ensemble come from: `draws` (a multiple of law::kGroups) surfaces of `prior`.
struct Ensemble {
  const Task& task;
  const TermSet& terms;
  const CoefficientPrior& prior;
  int draws = 0;
};

/// Of the rays of all draws together, each on a fresh pupil of a few thousand Sobol points per group.
EnsembleMean ensemble_by_rays(const Ensemble& ensemble, const std::vector<Statistic>& statistics,
                              int threads);
/// Of as many perturbed rays (Harvey-Shack), with `slope` per axis.
EnsembleMean ensemble_of_perturbed_rays(const Task& task, double slope, int draws,
                                        const std::vector<Statistic>& statistics, int threads);

/// What the report says of light: GHS of the equivalent surface against the diffraction of draws, or of
/// `given`, at those of `statistics` that light has: EE radii, and the ring width in the ring that holds 90 %
/// in theory.
void compare_in_light(const Ensemble& ensemble, const Groundwork& ground,
                      const std::optional<GivenSurface>& given, const std::vector<Statistic>& statistics,
                      int threads, VerifyReport* report);

/// TOST of means whose standard errors come from law::kGroups groups, with Student's t.
EquivalenceMetric tost_of_groups(const std::string& name, double target, double target_error, double model,
                                 double model_error, const EquivalenceSpec& test);

}  // namespace aberfit::internal
