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

/// Defocus of the farthest plane that a grid must represent for this statistic [m]; law::kReach times the
/// half width of a ring's profile.
double plane_reach(const Target& target);

/// Pitch [m] of the pupil grid for waves. Three conditions hold: 1.5 times the largest EE radius of `targets`
/// in all of their planes lies inside half of the field of view; the highest frequency of `terms` and of the
/// mirror's known Zernikes has three grid cells per cycle; there are at least 128 grid cells across.
/// coarsening: factor on all of these but the cells per cycle; at 2 the same radius just fits into the field
/// of view, and there are 64 grid cells across. split: of the roughness, null without. Energy scattered by
/// its rest needs no field of view, so no radius counts beyond the reach of its low part. least_reach:
/// smallest reach of the energy [m], for a surface that may differ from the specification.
double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets,
                  const BandSplit* split, double coarsening = 1, double least_reach = 0);

/// Returns whether waves on this many grid cells use single precision (DiffractionProblem): from
/// law::kManyCells on, where no tolerance is below 1e-4 of its target, hundreds of times the rounding.
bool in_single_precision(FocusModel model, const TargetSets& targets, Eigen::Index cells);
/// Number of grid cells of `pitch` [m] on the clear aperture; 0 for no grid.
Eigen::Index cells_of(const Task& task, double pitch);
/// The points from which a surface is propagated: rays, or the grid cells of `pitch` [m].
PupilSample focus_pupil(const Task& task, FocusModel model, const PupilOptions& rays, double pitch);

/// The mirror of a task at its wavelengths, with the rest of its roughness as scatter. split: null: none.
LitMirror lit_mirror(const Task& task, std::shared_ptr<const BandSplit> split);

}  // namespace aberfit
