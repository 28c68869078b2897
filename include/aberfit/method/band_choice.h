#pragma once
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"

namespace aberfit {

/// The rule of a task's band, the default resolved.
BandRule band_rule(const Task& task);

/// What a task asks for, laid out: its physics, its targets, and where its roughness is split.
struct Layout {
  Groundwork ground;
  TargetSets targets;
};

/// Why the roughness of these targets cannot be split, a clause; empty: it can. Scatter multiplies a transfer
/// function, and angles of terms and scatter add in squares.
std::string obstacle_to_split(const Groundwork& ground, const TargetSets& targets);

/// Groundwork, then targets, then the split that the task's `terms.band` asks for. Throws FieldError for a
/// band that the task's physics cannot split: scatter multiplies a transfer function, which only waves with
/// targets by generalised Harvey-Shack have; under a theory of rays it is a slope of every ray's own, at a
/// cut that the study names.
Layout lay_out(const Task& task, const PhysicsRequest& asked, int threads);
/// The same once for each of these bands in place of the task's own; targets and spread are computed once.
std::vector<Layout> lay_out(const Task& task, const PhysicsRequest& asked, const std::vector<BandSpec>& bands,
                            int threads);
/// By the physics that the task itself asks for.
Layout lay_out(const Task& task, int threads);
/// The same with the split at `cut` [cycles/m], or at the bottom of the band where that is above it, whatever
/// `terms.band` says; above the band there is no split. By waves, for tasks that have a theory of light; the
/// sentence of the shares is left to the caller.
Layout lay_out_at(const Task& task, double cut, int threads);

}  // namespace aberfit
