#pragma once
#include <memory>

#include "aberfit/method/judge.h"
#include "aberfit/method/scene.h"
#include "aberfit/study/run_options.h"

namespace aberfit {

/// The pupil that is fitted on, with the operators that live on it.
struct Workbench {
  FocusModel model;
  double pitch;  ///< of a grid for waves [m]
  PupilSample pupil;
  SurfaceOperator surface;
  RayBundle nominal;

  Workbench(const Study& study, FocusModel by, double grid_pitch, const TermSet& terms, int threads);
  SurfaceField field(const Eigen::VectorXd& coefficients) const;
  /// Unsmoothed statistics; NaN where one does not exist, with a warning when asked for.
  Eigen::VectorXd exact(const Study& study, const Eigen::VectorXd& coefficients,
                        const std::vector<Statistic>& statistics, int threads, Warnings* warnings) const;
  LightPath focus(const Study& study) const;
};

/// How far a fit goes. The default is the fit of a study with explicit terms, to the last bit.
struct Effort {
  int most_iterations = 1 << 30;
  Eigen::VectorXd warm;           ///< white coordinates to start from instead of a draw
  bool give_up_on_stall = false;  ///< a search has other sets to try
};

/// One fit of explicit terms on so many rays, and what goes on from it.
struct Attempt {
  ResultDocument result;
  std::shared_ptr<const Workbench> bench;
  CoefficientPrior prior;
  FreshStatistics fresh;  ///< empty where the fit was not judged
  double captured = 0;
  double mismatch = HUGE_VAL;  ///< worst, in tolerances
  bool met = false;            ///< every tolerance
};

/// Whether the solver got anywhere: a degenerate or failed try has no cost to compare.
bool has_solution(const FitResult& fit);

/// Fits what `study` names, on the rays it names. Not judged.
Attempt attempt_fit(const Study& study, const Scene& scene, const TargetSets& targets,
                    const RunOptions& options, const Effort& effort, int threads);

/// The same on the study's rays, or on more and more until fresh ones say the same; judged on fresh rays.
/// judge_always: a search does not care what fresh rays say of a set that misses its tolerances.
Attempt fit_on_enough_rays(Study study, const Scene& scene, const TargetSets& targets,
                           const RunOptions& options, const Effort& effort, bool judge_always, int threads);

}  // namespace aberfit
