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
  bool single_precision = false;  ///< as DiffractionProblem has it

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
};

/// Says of a result what is known of its scene: models, targets, where the roughness is split, and warnings.
/// result: with terms; captured: as in TermPlan.
void describe_scene(const FitCase& of, double captured, FitOutcome* result);

/// What is known of a result before the solve.
FitOutcome outcome_of(const FitCase& of, const FitPlan& plan);

/// Judged, and equivalent.
bool is_equivalent(const Attempt& attempt);
/// The worst judged difference in margins, infinite where a judged statistic has no value; of an attempt that
/// was not judged the worst mismatch in tolerances.
double distance_to_margin(const Attempt& attempt);

/// Whether the solver got anywhere: a degenerate or failed try has no cost to compare.
bool has_solution(const FitResult& fit);

/// One fit as planned, on the rays of the plan. Not judged.
Attempt attempt_fit(const FitCase& of, const FitPlan& plan);

/// The fit of the plan's terms and start, judged, on a sample fine enough: by rays on those that are asked
/// for, or on more and more until fresh ones say the same; by waves on finer and finer grids, each from where
/// the one before ended, until the grid that judges says the same of what is fitted. Where the run was asked
/// to stop, the last that was judged.
Attempt fit_on_a_fine_enough_sample(const FitCase& of, FitPlan plan);

}  // namespace aberfit
