#pragma once
#include <limits>
#include <memory>

#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/run_context.h"

namespace aberfit {

/// The pupil that is fitted on, with the operators that live on it.
struct Workbench {
  FocusModel model;
  std::shared_ptr<const MeanScatter> scatter;  ///< of the rest of a split roughness; null: none
  double pitch;                                ///< of a grid for waves [m]
  PupilSample pupil;
  SurfaceOperator surface;
  double wide_circles = std::numeric_limits<double>::infinity();  ///< as DiffractionProblem has it
  bool single_precision = false;                                  ///< likewise
  double met_within = 1;  ///< of the targets' tolerances, before a fit ends

  Workbench(const Task& task, FocusModel by, const PupilOptions& rays, double grid_pitch,
            const TermSet& terms, int threads, std::shared_ptr<const BandSplit> split = {});
  SurfaceField field(const Eigen::VectorXd& coefficients) const;
  /// Unsmoothed statistics; NaN where one does not exist, with a warning when asked for.
  Eigen::VectorXd exact(const Task& task, const Eigen::VectorXd& coefficients,
                        const std::vector<Statistic>& statistics, int threads, Warnings* warnings) const;
  LightPath focus(const Task& task) const;
};

/// What all fits of a run have in common. The parts must outlive it.
struct FitCase {
  const Task& task;
  const Groundwork& ground;
  const TargetSets& targets;
  const RunContext& context;
};

/// One fit, and what goes on from it.
struct Attempt {
  FitOutcome result;
  std::shared_ptr<const TermPlan> terms;
  std::shared_ptr<const Workbench> bench;
  FreshStatistics fresh;          ///< of a JudgedSet's statistics; empty where the fit was not judged
  Eigen::VectorXd first_seen;     ///< the values of `fresh` before finer grids were asked for what was open
  Eigen::VectorXd own;            ///< on the fit's own points: what is judged of each fitted target
  Warnings own_warnings;          ///< of statistics there; said where no fresh points say it anew
  Warnings fresh_warnings;        ///< of `fresh`
  double judging_coarsening = 1;  ///< of the grid for waves of `first_seen`, over the safe pitch
  double mismatch = HUGE_VAL;     ///< worst, in tolerances
  double met_within = 1;          ///< of Workbench: in tolerances
  bool met = false;               ///< every tolerance, to `met_within`
};

/// Says of a result what is known of its scene: models, targets, where the roughness is split, and warnings.
/// result: with terms; captured: as in TermPlan.
void describe_scene(const FitCase& of, double captured, FitOutcome* result);

/// What is known of a result before the solve.
FitOutcome outcome_of(const FitCase& of, const FitPlan& plan);

/// Every tolerance met, to `met_within`, and what was judged is equivalent.
bool is_equivalent(const Attempt& attempt);
/// The worst that is known of an attempt: mismatches over what they may be, in tolerances, judged differences
/// in margins; infinite where a judged statistic has no value.
double distance_to_margin(const Attempt& attempt);
/// Whether a is the one to keep: what meets the tolerances before what does not, then the smaller distance to
/// the margin or, of those that do not, to the tolerances.
bool nearer(const Attempt& a, const Attempt& b);

/// Whether the solver got anywhere: a degenerate or failed try has no cost to compare.
bool has_solution(const FitResult& fit);

/// One fit as planned, on the rays of the plan. Not judged.
Attempt attempt_fit(const FitCase& of, const FitPlan& plan);

/// One on the plan's rays, or on more and more until fresh ones say the same; judged on fresh rays. By
/// waves on finer and finer grids, and from the plan's starts in turn until one is equivalent.
/// Not judged where the run was asked to stop. judge_always: a search does not care what fresh rays say of a
/// set that misses its tolerances.
Attempt fit_on_enough_rays(const FitCase& of, FitPlan plan, bool judge_always);

}  // namespace aberfit
