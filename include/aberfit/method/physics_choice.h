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

/// What the targets come from, what the surface goes through, and whose verdict it is.
struct PhysicsChoice {
  Theory theory = Theory::kGeometric;
  FocusModel model = FocusModel::kRays;  ///< of the surface
  std::optional<ModelChoice> choice;     ///< of the specification; absent without roughness
  std::string reason = "No roughness is given, so nothing says which model the scene needs: rays are used.";
  std::string obstacle;  ///< why wave optics cannot be computed for this task, a clause; empty: it can
  std::optional<TheoryError>
      theory_error;  ///< of wave optics for the specification; absent where it has none
  /// Whether the verdict is that of light. It is not where a study names the geometric theory or rays as its
  /// theory, nor in convention `paper`, a rule for rays: then light's answer stands beside it.
  bool light_decides = true;
  Warnings warnings;

  /// Whether targets and surface are light's own already. Given targets have no theory.
  bool in_light(bool targets_are_given) const;
};

/// Theory and model that somebody asks for; absent: what the scene needs.
struct PhysicsRequest {
  std::optional<Theory> theory;
  std::optional<FocusModel> model;
};
/// What the task asks for.
PhysicsRequest requested_physics(const Task& task);

/// The models of a task. psd: of the specification, null without. `auto`: targets by generalised
/// Harvey-Shack, the surface by rays where their error against light is below law::kShareOfMargin of the
/// margin, else by waves. Convention `paper` is a rule for rays - no wave of any surface turns by its slope
/// alone - so with it `auto` stays geometric, as it does, with a warning `theory-fallback`, where there is no
/// wave theory of the task: statistics about the centroid, or too much of the light scattered
/// further than the theory goes. Throws FieldError where a theory or model that is asked for cannot be
/// computed.
PhysicsChoice choose_physics(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd);

/// The task without the statistics that geometric rays do not have (a Strehl ratio, say), for what compares
/// rays with light; without any, it asks for the default set.
Task seen_by_rays(Task task);

/// Throws FieldError at its key for a statistic that only rays have: the RMS radius, which diffraction makes
/// infinite. `model`: the theory or the model that lacks it.
void refuse_without_rays(const std::string& model, const std::vector<Statistic>& statistics);

}  // namespace aberfit
