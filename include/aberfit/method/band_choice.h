#pragma once
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"

namespace aberfit {

/// The band rule of a task; kDefault is resolved.
BandRule band_rule(const Task& task);

/// The layout of a task: its physics, its targets, and the split of its roughness.
struct Layout {
  Groundwork ground;
  TargetSets targets;
};

/// Returns why the roughness of these targets cannot be split, a clause; empty: it can. A split needs scatter
/// that multiplies a transfer function, and angles of terms and scatter that add in squares.
std::string obstacle_to_split(const Groundwork& ground, const TargetSets& targets);

/// Makes the groundwork, then the targets, then the split of the task's `terms.band`. With wave optics and
/// targets by generalised Harvey-Shack, scatter multiplies a transfer function. Under a theory of rays,
/// scatter is an independent slope of each ray, and the study must name the cut. Throws FieldError for a band
/// that the task's physics cannot split.
Layout lay_out(const Task& task, const PhysicsRequest& asked, int threads);
/// The same once for each of these bands in place of the task's own; targets and spread are computed once.
std::vector<Layout> lay_out(const Task& task, const PhysicsRequest& asked, const std::vector<BandSpec>& bands,
                            int threads);
/// The same with the physics of the task itself.
Layout lay_out(const Task& task, int threads);
/// The same with the split at `cut` [cycles/m], whatever `terms.band` is. A cut below the band moves to its
/// lower end; a cut above the band gives no split. Only for wave optics and tasks with a wave theory. The
/// caller fills BandShares::reason.
Layout lay_out_at(const Task& task, double cut, int threads);

}  // namespace aberfit
