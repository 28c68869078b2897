#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/forward/forward_model.h"
#include "aberfit/method/groundwork.h"

namespace aberfit {

/// A surface error that comes from elsewhere (a file, say) instead of a draw.
struct GivenSurface {
  TermSet terms;
  Eigen::VectorXd coefficients;  ///< [m], in the order of `terms`
};

/// One statistic of a traced surface beside its target.
struct TracedStatistic {
  Statistic statistic;
  double value = 0;   ///< of the surface, in the statistic's unit; NaN: does not exist
  double target = 0;  ///< what a fit of the same task aims at
};

/// Focal statistics of a surface, nothing else.
struct TraceReport {
  std::string title;                     ///< of the task, for people
  std::string theory;                    ///< "geometric", "rays", "ghs", "given": of the targets
  FocusModel model = FocusModel::kRays;  ///< what turned the surface into statistics
  std::string reason;                    ///< one sentence: which model the scene needs and why
  Eigen::Index rays = 0, lost_rays = 0;  ///< rays, or cells of the pupil grid of waves
  Eigen::Index terms = 0;
  std::vector<TracedStatistic> statistics;
  Warnings warnings;
};

/// What the statistics of a trace are taken from.
struct TracedLight {
  const Groundwork& ground;
  const TargetSets& targets;
  const PupilSample& pupil;
  const RayBundle &rays, &nominal;  ///< of the pupil, by waves of its cells
  const LightPath* waves;           ///< null by rays
  const Eigen::VectorXd& coefficients;
};

/// Traces the given surface, or the draw of the task's seed, with the model and the normals of the task.
/// look, when given, sees the light while it is there. Throws FieldError for central differences of anything
/// but rays.
TraceReport trace_surface(const Task& task, const std::optional<GivenSurface>& given, int threads,
                          const std::function<void(const TracedLight&)>& look = {});

}  // namespace aberfit
