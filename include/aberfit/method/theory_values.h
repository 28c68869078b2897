#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/method/physics_choice.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/regime.h"

namespace aberfit {

/// Results of theory for a specification, without any surface.
struct TheoryValues {
  std::string theory;    ///< "geometric", "rays", "ghs", or "given" where every statistic has a value
  SceneNumbers numbers;  ///< without `reason` and `kappa_rule_allows_rays`, which need a surface
  std::vector<std::pair<Statistic, double>> statistics;  ///< value in the statistic's unit
  Warnings warnings;                                     ///< of the data
};

/// The pupil for generalised Harvey-Shack of a task.
GhsPupil pupil_of_task(const Task& task);

/// The task's statistics with the values of make_targets. Without any: ee50, ee80 and ee90 in the focus,
/// scatter_rms and rms_height. Values are by the closed form even where lay_groundwork takes rays because of
/// steep slopes. Takes some milliseconds, a hundredth of the layout of a fit: no model is chosen, no
/// statistic is held out, the band is not split. Theory `rays` has no closed form and takes as long as in
/// make_targets. Throws FieldError as make_targets does, and for a task without roughness; ComputationError
/// where the theory has no value. pupil_of: returns the pupil of its mirror, aperture and wavelength, for
/// callers that keep it; computing it is half of the time.
TheoryValues theory_values(const Task& task,
                           const std::function<GhsPupil(const Task&)>& pupil_of = pupil_of_task);

/// The theory of the task's targets by choose_physics, before the check for slopes too steep for a closed
/// form. psd: of the specification.
Theory theory_of_targets(const Task& task, const RadialPsd& psd);

}  // namespace aberfit
