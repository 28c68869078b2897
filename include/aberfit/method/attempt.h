#pragma once
#include <limits>
#include <memory>

#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/run_context.h"

namespace aberfit {

/// The pupil used for a fit, with the operators defined on it.
struct Workbench {
  FocusModel model;
  std::shared_ptr<const MeanScatter> scatter;  ///< mean scatter of the rest of a split roughness; null: none
  double pitch;                                ///< pitch of the pupil grid for wave optics [m]
  PupilSample pupil;
  SurfaceOperator surface;
  bool single_precision = false;  ///< precision of the transforms, see DiffractionProblem

  Workbench(const Task& task, FocusModel by, const PupilOptions& rays, double grid_pitch,
            const TermSet& terms, int threads, std::shared_ptr<const BandSplit> split = {});
  SurfaceField field(const Eigen::VectorXd& coefficients) const;
  /// Unsmoothed statistics; NaN where one does not exist, with a warning unless `warnings` is null.
  Eigen::VectorXd exact(const Task& task, const Eigen::VectorXd& coefficients,
                        const std::vector<Statistic>& statistics, int threads, Warnings* warnings) const;
  LightPath focus(const Task& task) const;
};

/// The parts that all fits of a run share. They must outlive this struct.
struct FitCase {
  const Task& task;
  const Groundwork& ground;
  const TargetSets& targets;
  const RunContext& context;
};

/// One fit, and the data needed to continue from it.
struct Attempt {
  FitOutcome result;
  std::shared_ptr<const TermPlan> terms;
  std::shared_ptr<const Workbench> bench;
  FreshStatistics fresh;  ///< statistics of the JudgedSet on fresh points; empty where the fit was not judged
  Eigen::VectorXd first_seen;  ///< `fresh` on the first judging grid, before finer grids
  Eigen::VectorXd own;         ///< judged value of each fitted target on the fit's own points
  Warnings own_warnings;  ///< warnings from the fit's own points; reported where no fresh points repeat them
  Warnings fresh_warnings;        ///< warnings from `fresh`
  double judging_coarsening = 1;  ///< pitch of the grid behind `first_seen`, over the safe pitch
  double mismatch = HUGE_VAL;     ///< largest mismatch, in tolerances
};

/// Writes the known facts of the scene into `result`: models, targets, split of the roughness, and warnings.
/// result: has its terms already; captured: as in TermPlan.
void describe_scene(const FitCase& of, double captured, FitOutcome* result);

/// The outcome as known before the solve.
FitOutcome outcome_of(const FitCase& of, const FitPlan& plan);

/// True when the attempt was judged and its verdict is `equivalent`.
bool is_equivalent(const Attempt& attempt);
/// The largest judged difference in margins; infinite where a judged statistic has no value. An attempt that
/// was not judged gives its largest mismatch in tolerances.
double distance_to_margin(const Attempt& attempt);

/// True when the solver has a usable solution. A degenerate or failed solve has no cost to compare.
bool has_solution(const FitResult& fit);

/// Makes one fit on the pupil of the plan. It is not judged.
Attempt attempt_fit(const FitCase& of, const FitPlan& plan);

/// Fits the plan's terms from its start on a sample that is fine enough, and judges the result. Rays: the
/// requested number, or more and more until fresh rays agree. Waves: finer and finer grids, each fit starting
/// from the previous one, until the judging grid agrees with the fitted statistics. If the run is
/// interrupted, returns the last judged attempt.
Attempt fit_on_a_fine_enough_sample(const FitCase& of, FitPlan plan);

}  // namespace aberfit
