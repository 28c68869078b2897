#include "aberfit/method/physics_choice.h"

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

// Why diffraction about the perfect focus says nothing about this task.
std::string obstacle_of(const Task& task) {
  if (!is_parabola(task.mirror)) return "the mirror is no parabola, so it has no perfect focus";
  if (std::holds_alternative<PolygonAperture>(task.aperture))
    return "the diffraction pattern of a polygon is not part of the theory";
  if (task.trace.centre == Centre::kCentroid) return "statistics about the centroid exist for rays only";
  return "";
}

// What a study names must be computable; what is left to the program may fall back.
void check_named(const Task& task, const PhysicsRequest& asked, const std::string& obstacle) {
  const bool ghs = asked.theory == Theory::kGhs, waves = asked.model == FocusModel::kWaves;
  const bool paper = task.target.convention == Convention::kPaper;
  if (ghs && paper)
    throw FieldError("target.theory", "\"ghs\" with convention \"paper\", a rule for rays alone",
                     "\"auto\", \"geometric\", \"rays\"; or convention \"physical\"");
  if (ghs && !obstacle.empty())
    throw FieldError("target.theory", "\"ghs\", but " + obstacle, "\"auto\", \"geometric\", \"rays\"");
  if (asked.theory == Theory::kGeometric && !is_rotationally_symmetric(task.mirror))
    throw FieldError("target.theory",
                     "\"geometric\", a closed form for mirrors of revolution, but mirror.zernike has "
                     "terms with m != 0",
                     "\"rays\", the same theory by drawn deflections; \"auto\"");
  if (waves && !obstacle.empty())
    throw FieldError("trace.model", "\"waves\", but " + obstacle, "\"auto\", \"rays\"");
}

}  // namespace

bool PhysicsChoice::too_simple(bool targets_are_given) const {
  if (!choice || choice->model == FocusModel::kRays) return false;
  return model == FocusModel::kRays || (!targets_are_given && model_of(theory) == FocusModel::kRays);
}

PhysicsRequest requested_physics(const Task& task) { return {task.target.theory, task.trace.model}; }

PhysicsChoice choose_physics(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd) {
  PhysicsChoice use;
  use.obstacle = obstacle_of(task);
  check_named(task, asked, use.obstacle);
  if (psd) {
    use.choice = choose_model(*psd, task.mirror, task.aperture, task.wavelength);
    use.reason = use.choice->reason;
  }
  if (asked.theory) {
    use.theory = *asked.theory;
  } else {
    use.theory = use.choice ? theory_of(use.choice->model) : Theory::kGeometric;
    if (use.theory != Theory::kGeometric && task.target.convention == Convention::kPaper) {
      use.theory = Theory::kGeometric;
      use.warnings.push_back({"theory-fallback",
                              "convention `paper` is a rule for rays and has no wave counterpart: targets "
                              "and surface stay geometric, although the scene needs more"});
    } else if (use.theory != Theory::kGeometric && !use.obstacle.empty()) {
      use.theory = Theory::kGeometric;
      use.warnings.push_back({"theory-fallback", "the scene needs more than geometric rays, but " +
                                                     use.obstacle + ": targets and surface stay geometric"});
    }
  }
  // The closed form exists for mirrors of revolution only; drawn deflections are the same theory.
  if (use.theory == Theory::kGeometric && !is_rotationally_symmetric(task.mirror)) use.theory = Theory::kRays;
  use.model = asked.model.value_or(model_of(use.theory));
  return use;
}

void refuse_without_rays(const std::string& model, const std::vector<Statistic>& statistics) {
  for (const Statistic& statistic : statistics)
    if (std::holds_alternative<RmsRadius>(statistic))
      throw FieldError(
          "target.statistics.rms_radius",
          "an RMS radius with model \"" + model + "\": diffraction at the edge makes it infinite",
          "ee radii; or theory \"geometric\" and trace model \"rays\"");
}

}  // namespace aberfit
