#pragma once
#include <memory>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// How far out of focus the farthest plane lies that a grid has to show for this statistic [m]; rings are
/// looked for beyond the half of their light.
double plane_reach(const Target& target);

/// Pitch [m] of the pupil grid for waves: light at 1.5 times the largest EE radius of `targets` in all of
/// their planes stays inside half of the field of view, the highest frequency of `terms` and of the
/// mirror's known Zernikes gets three cells a cycle, and there are at least 128 cells across. coarsening:
/// factor on all of this but the terms' cells; at 2 the same light just fits into the field of view, and
/// there are 64 cells across.
/// split: of the roughness, null where there is none. Light that its rest scatters needs no room on a grid:
/// no radius counts beyond the low part's reach. least_reach: of the light of a surface that need not be as
/// specified [m].
double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets,
                  const BandSplit* split, double coarsening = 1, double least_reach = 0);

/// Whether waves on so many cells work in single precision (DiffractionProblem): from
/// law::kManyCells on, where no tolerance is below 1e-4 of its target, hundreds of times the rounding.
bool in_single_precision(FocusModel model, const TargetSets& targets, Eigen::Index cells);
/// Cells of a grid of `pitch` [m] on the clear aperture; 0 for none.
Eigen::Index cells_of(const Task& task, double pitch);
/// The points that a surface is propagated from: rays, or the cells of a grid of `pitch` [m].
PupilSample focus_pupil(const Task& task, FocusModel model, const PupilOptions& rays, double pitch);

/// The mirror of a task in its light, with the rest of its roughness as scatter. Null: none.
LitMirror lit_mirror(const Task& task, std::shared_ptr<const BandSplit> split);

}  // namespace aberfit
