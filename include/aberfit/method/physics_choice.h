#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/method/task.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/theory/theory_error.h"

namespace aberfit {

/// The theory of the targets, the model of the surface, and the model that gives the verdict.
struct PhysicsChoice {
  Theory theory = Theory::kGeometric;
  FocusModel model = FocusModel::kRays;  ///< model of the surface
  std::optional<ModelChoice> choice;     ///< model for the specification; absent without roughness
  std::string reason = "No roughness is given, so the needed model is unknown and rays are used.";
  std::string obstacle;  ///< why wave optics cannot be computed for this task, a clause; empty: it can
  std::optional<TheoryError>
      theory_error;  ///< error of wave optics for the specification; absent where it has none
  /// True when wave optics gives the verdict. Rays give it where a study names the geometric theory or rays,
  /// and in convention `paper`, which is a rule for rays. The wave-optics judgement is then shown beside it.
  bool light_decides = true;
  Warnings warnings;

  /// Returns whether targets and surface both come from wave optics. Given targets have no theory.
  bool in_light(bool targets_are_given) const;
};

/// A requested theory and model; absent: what the scene needs.
struct PhysicsRequest {
  std::optional<Theory> theory;
  std::optional<FocusModel> model;
};
/// The request of the task itself.
PhysicsRequest requested_physics(const Task& task);

/// The models of a task. psd: of the specification, null without roughness. `auto`: targets by generalised
/// Harvey-Shack. The surface is modelled by rays where their error against wave optics is below
/// law::kShareOfMargin of the margin, else by waves. Convention `paper` is a rule for rays, because no
/// wavefront of a surface tilts by its slope alone; `auto` then stays geometric. It also stays geometric,
/// with a warning `theory-fallback`, where the task has no wave theory: statistics about the centroid, or too
/// much energy scattered beyond the angles of the theory. Throws FieldError where a requested theory or model
/// cannot be computed.
PhysicsChoice choose_physics(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd);

/// The task without statistics that geometric rays lack (a Strehl ratio, for example), for comparing rays
/// with wave optics. If none is left, the task has the default set.
Task seen_by_rays(Task task);

/// Throws FieldError at its key for a statistic that only rays have: the RMS radius, which diffraction makes
/// infinite. `model`: the theory or the model that lacks it.
void refuse_without_rays(const std::string& model, const std::vector<Statistic>& statistics);

}  // namespace aberfit
