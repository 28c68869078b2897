#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/method/task.h"
#include "aberfit/theory/model_choice.h"

namespace aberfit {

/// What the targets come from, what the surface goes through, and what the scene needs.
struct PhysicsChoice {
  Theory theory = Theory::kGeometric;
  FocusModel model = FocusModel::kRays;  ///< of the surface
  std::optional<ModelChoice> choice;     ///< of the specification; absent without roughness
  std::string reason = "No roughness is given, so nothing says which model the scene needs: rays are used.";
  std::string obstacle;  ///< why wave optics cannot be computed for this task, a clause; empty: it can
  Warnings warnings;

  /// Whether `theory` or `model` is simpler than what the scene needs. Given targets have no theory.
  bool too_simple(bool targets_are_given) const;
};

/// Theory and model that somebody asks for; absent: what the scene needs.
struct PhysicsRequest {
  std::optional<Theory> theory;
  std::optional<FocusModel> model;
};
/// What the task asks for.
PhysicsRequest requested_physics(const Task& task);

/// The models of a task. psd: of the specification, null without. Convention `paper` is a rule for rays - no
/// wave of any surface turns by its slope alone - so with it `auto` stays geometric, and the regime is that
/// of the specification. `auto` also stays geometric, with a warning `theory-fallback`, where waves
/// would be needed but cannot be computed: a mirror that is no parabola, a polygon, statistics about
/// the centroid. Throws FieldError where a theory or model that is asked for cannot be computed.
PhysicsChoice choose_physics(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd);

/// Throws FieldError at its key for a statistic that only rays have: the RMS radius, which diffraction makes
/// infinite. `model`: the theory or the model that lacks it.
void refuse_without_rays(const std::string& model, const std::vector<Statistic>& statistics);

}  // namespace aberfit
