#include "aberfit/method/physics_choice.h"

#include <algorithm>

#include "aberfit/core/errors.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/theory_values.h"
#include "aberfit/scene/segments.h"

namespace aberfit {
namespace {

// The error of wave optics for this roughness: an obstacle where it is large, else a warning.
void mind_theory(const Task& task, const RadialPsd& psd, PhysicsChoice* use) {
  try {
    use->theory_error = theory_error(psd, task.mirror, task.aperture, task.wavelength);
  } catch (const ComputationError& error) {
    if (use->obstacle.empty()) use->obstacle = error.what();
    return;
  }
  const TheoryError& error = *use->theory_error;
  if (!error.applies && use->obstacle.empty()) use->obstacle = error.clause;
  if (!error.applies) return;
  if (error.wide_angles) use->warnings.push_back({"wide-angle-scatter", error.clause});
  if (error.mostly_grazing) use->warnings.push_back({"grazing-incidence", error.of_grazing});
}

bool is_of_light_alone(const StatisticRequest& request) {
  return request.name != "ring_profile" && !kind_of_key(request.name).in_rays();
}

// The first requested statistic that only wave optics has; null: none.
const StatisticRequest* of_light_alone(const Task& task) {
  const auto& asked = task.target.statistics;
  const auto found = std::find_if(asked.begin(), asked.end(), is_of_light_alone);
  return found == asked.end() ? nullptr : &*found;
}

void refuse_without_waves(const Task& task, const PhysicsRequest& asked, const std::string& obstacle) {
  const StatisticRequest* request = of_light_alone(task);
  if (!request) return;
  const std::string field = "target.statistics." + request->name;
  if (asked.theory && *asked.theory != Theory::kGhs)
    throw FieldError(field, "a wave-optics statistic with theory \"" + to_string(*asked.theory) + "\"",
                     "theory \"auto\" or \"ghs\"; or ee radii");
  if (asked.model == FocusModel::kRays)
    throw FieldError(field, "a wave-optics statistic with trace model \"rays\"",
                     "trace model \"auto\" or \"waves\"; or ee radii");
  if (task.target.convention == Convention::kPaper || !obstacle.empty())
    throw FieldError(field,
                     "a wave-optics statistic, but " +
                         (obstacle.empty() ? "convention \"paper\" is a rule for rays only" : obstacle),
                     "ee radii");
}

// A theory or model named by the study must be computable; an automatic one may fall back.
void check_named(const Task& task, const PhysicsRequest& asked, const std::string& obstacle) {
  const bool ghs = asked.theory == Theory::kGhs, waves = asked.model == FocusModel::kWaves;
  const bool paper = task.target.convention == Convention::kPaper;
  if (ghs && paper)
    throw FieldError("target.theory", "\"ghs\" with convention \"paper\", a rule for rays only",
                     "\"auto\", \"geometric\", \"rays\"; or convention \"physical\"");
  if (ghs && !obstacle.empty())
    throw FieldError("target.theory", "\"ghs\", but " + obstacle, "\"auto\", \"geometric\", \"rays\"");
  if (asked.theory == Theory::kGeometric && !is_rotationally_symmetric(task.mirror))
    throw FieldError(
        "target.theory",
        "\"geometric\", a closed form for mirrors of revolution, but mirror.zernike has terms with m != 0",
        "\"rays\", the same theory by random deflections; or \"auto\"");
  if (has_segment_errors(task.aperture)) {
    const std::string allowed = "\"auto\" or \"ghs\"; or segments without `piston` and `tip_tilt`";
    if (asked.theory && !ghs)
      throw FieldError("target.theory", "\"" + to_string(*asked.theory) + "\" with segment errors", allowed);
    if (asked.model == FocusModel::kRays)
      throw FieldError("trace.model", "\"rays\" with segment errors", "\"auto\" or \"waves\"");
    if (paper || !obstacle.empty())
      throw FieldError(
          "aperture.piston",
          "segment errors, but " + (paper ? "convention \"paper\" is a rule for rays only" : obstacle),
          "segments without `piston` and `tip_tilt`");
  }
  if (waves && !obstacle.empty())
    throw FieldError("trace.model", "\"waves\", but " + obstacle, "\"auto\", \"rays\"");
  refuse_without_waves(task, asked, obstacle);
}

// Fills `obstacle` where wave optics cannot be computed, before theory and model are chosen.
PhysicsChoice wave_optics_of(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd) {
  PhysicsChoice use;
  if (task.trace.centre == Centre::kCentroid)
    use.obstacle = "statistics about the centroid exist for rays only";
  if (psd) mind_theory(task, *psd, &use);
  check_named(task, asked, use.obstacle);
  return use;
}

// The closed form exists for rotationally symmetric mirrors only; random deflections follow the same theory.
Theory geometric_theory(const Task& task) {
  return is_rotationally_symmetric(task.mirror) ? Theory::kGeometric : Theory::kRays;
}

}  // namespace

bool PhysicsChoice::in_light(bool targets_are_given) const {
  return model == FocusModel::kWaves && (targets_are_given || theory == Theory::kGhs);
}

PhysicsRequest requested_physics(const Task& task) { return {task.target.theory, task.trace.model}; }

PhysicsChoice choose_physics(const Task& task, const PhysicsRequest& asked, const RadialPsd* psd) {
  PhysicsChoice use = wave_optics_of(task, asked, psd);
  const bool paper = task.target.convention == Convention::kPaper;
  if (psd) {
    use.choice = choose_model(*psd, task.mirror, task.aperture, task.wavelength,
                              law::kShareOfMargin * task.equivalence.margin);
    use.reason = use.choice->reason;
  }
  if (asked.theory) {
    use.theory = *asked.theory;
  } else if (use.choice && (paper || !use.obstacle.empty())) {
    if (use.choice->model != FocusModel::kRays)
      use.warnings.push_back(
          {"theory-fallback", paper
                                  ? "convention `paper` is a rule for rays and has no wave counterpart. "
                                    "Targets and surface stay geometric, although the scene needs wave optics"
                                  : "the scene needs wave optics, but " + use.obstacle +
                                        "; targets and surface stay geometric"});
  } else if (use.choice) {
    use.theory = Theory::kGhs;
  }
  use.light_decides = use.obstacle.empty() && !paper && (!asked.theory || *asked.theory == Theory::kGhs);
  const FocusModel own = of_light_alone(task) || has_segment_errors(task.aperture) ? FocusModel::kWaves
                         : use.theory == Theory::kGhs && !asked.theory             ? use.choice->model
                                                                                   : model_of(use.theory);
  if (use.theory == Theory::kGeometric) use.theory = geometric_theory(task);
  use.model = asked.model.value_or(own);
  return use;
}

Theory theory_of_targets(const Task& task, const RadialPsd& psd) {
  const PhysicsRequest asked = requested_physics(task);
  const PhysicsChoice use = wave_optics_of(task, asked, &psd);
  const bool light = use.obstacle.empty() && task.target.convention != Convention::kPaper;
  const Theory theory = asked.theory.value_or(light ? Theory::kGhs : Theory::kGeometric);
  return theory == Theory::kGeometric ? geometric_theory(task) : theory;
}

Task seen_by_rays(Task task) {
  std::erase_if(task.target.statistics, is_of_light_alone);
  return task;
}

void refuse_without_rays(const std::string& model, const std::vector<Statistic>& statistics) {
  for (const Statistic& statistic : statistics)
    if (!kind_of(statistic).in_waves())
      throw FieldError(
          "target.statistics." + std::string(kind_of(statistic).key),
          "an RMS radius with model \"" + model + "\", where diffraction at the edge makes it infinite",
          "ee radii; or theory \"geometric\" and trace model \"rays\"");
}

}  // namespace aberfit
