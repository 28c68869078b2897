#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/task.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// Pitch [m] of the pupil grid for waves: light at 1.5 times the largest EE radius of `targets` in all of
/// their planes stays inside half of the field of view, the highest frequency of `terms` and of the
/// mirror's known Zernikes gets three cells a cycle, and there are at least 128 cells across.
double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets);

/// The points that a surface is propagated from: rays, or the cells of a grid of `pitch` [m].
PupilSample focus_pupil(const Task& task, FocusModel model, const PupilOptions& rays, double pitch);

/// The mirror of a task in its light.
LitMirror lit_mirror(const Task& task);

}  // namespace aberfit
