#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/forward/focus_forward.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// The words of a study and of results: "geometric", "ghs", ...; "rays", "convolved", "waves".
std::string to_string(Theory theory);
std::string to_string(FocusPhysics physics);
/// The physics that a model needs: waves for kGhs.
FocusPhysics physics_of(FocusModel model);

/// What the targets come from, what the surface goes through, and what the scene needs.
struct ModelUse {
  Theory theory = Theory::kGeometric;          ///< never kAuto
  FocusPhysics physics = FocusPhysics::kRays;  ///< of the surface
  std::optional<ModelChoice> choice;           ///< of the specification; absent without roughness
  std::string reason = "No roughness is given, so nothing says which model the scene needs: rays are used.";
  std::string obstacle;  ///< why wave optics cannot be computed for this task, a clause; empty: it can
  Warnings warnings;

  /// Whether `theory` or `physics` is simpler than what the scene needs. Given targets have no theory.
  bool too_simple(bool targets_are_given) const;
};

/// The models of a task. psd: of the specification, null without. Convention `paper` is a rule for rays - no
/// wave of any surface turns by its slope alone - so with it `auto` stays geometric, and the regime is that
/// of the specification. `auto` also stays geometric, with a warning `theory-fallback`, where convolved rays
/// or waves would be needed but cannot be computed: a mirror that is no parabola, a polygon, statistics about
/// the centroid. Throws FieldError where a theory or model that the study names cannot be computed.
ModelUse decide_model(const Task& task, const RadialPsd* psd);

/// Throws FieldError at its key for a statistic that only rays have: the RMS radius, which diffraction makes
/// infinite. `model`: the theory or the physics that lacks it.
void refuse_without_rays(const Task& task, const std::string& model,
                         const std::vector<Statistic>& statistics);

/// Predicted statistics of the mean spot (no RmsRadius), with one MeanSpot per plane.
Eigen::VectorXd mean_spot_statistics(const GeneralisedHarveyShack& spot,
                                     const std::vector<Statistic>& statistics, int threads);

/// Pitch [m] of the pupil grid for waves: light at 1.5 times the largest EE radius of `targets` in all of
/// their planes stays inside half of the field of view, the highest frequency of `terms` gets three cells a
/// cycle, and there are at least 128 cells across.
double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets);

/// The points that a surface is propagated from: rays, or the cells of a grid of `pitch` [m].
PupilSample focus_pupil(const Task& task, FocusPhysics physics, const PupilOptions& rays, double pitch);
/// How L is to be computed there.
OperatorOptions focus_operator(FocusPhysics physics, int threads);

}  // namespace aberfit
