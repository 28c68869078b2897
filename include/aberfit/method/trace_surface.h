#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/forward/forward_model.h"
#include "aberfit/method/groundwork.h"

namespace aberfit {

/// A surface error from elsewhere, for example a file, instead of a random surface.
struct GivenSurface {
  TermSet terms;
  Eigen::VectorXd coefficients;  ///< [m], in the order of `terms`
};

/// One statistic of a traced surface beside its target.
struct TracedStatistic {
  Statistic statistic;
  double value = 0;   ///< value of the surface, in the statistic's unit; NaN: does not exist
  double target = 0;  ///< target of a fit of the same task
};

/// Focal statistics of a surface without a fit.
struct TraceReport {
  std::string title;                     ///< title of the task, for people
  std::string theory;                    ///< origin of the targets: "geometric", "rays", "ghs", "given"
  FocusModel model = FocusModel::kRays;  ///< model that gives the statistics of the surface
  std::string reason;                    ///< one sentence: which model the scene needs and why
  Eigen::Index rays = 0, lost_rays = 0;  ///< rays, or grid cells of the pupil by waves
  Eigen::Index terms = 0;
  std::vector<TracedStatistic> statistics;
  Warnings warnings;
};

/// The data from which the statistics of a trace are computed.
struct TracedLight {
  const Groundwork& ground;
  const TargetSets& targets;
  const PupilSample& pupil;
  const RayBundle &rays, &nominal;  ///< rays of the pupil; by waves those of its grid cells
  const LightPath* waves;           ///< null by rays
  const Eigen::VectorXd& coefficients;
};

/// Traces the given surface, or the random surface of the task's seed, with the model and normals of the
/// task. look: optional, receives the data. Throws FieldError for central differences without rays.
TraceReport trace_surface(const Task& task, const std::optional<GivenSurface>& given, int threads,
                          const std::function<void(const TracedLight&)>& look = {});

}  // namespace aberfit
