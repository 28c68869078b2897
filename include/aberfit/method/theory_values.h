#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/method/physics_choice.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/regime.h"

namespace aberfit {

/// What theory says of a specification, and nothing of a surface.
struct TheoryValues {
  std::string theory;  ///< "geometric", "rays", "ghs", or "given" where every statistic has a value
  SceneNumbers
      numbers;  ///< all but `reason` and `kappa_rule_allows_rays`, which say which model a surface needs
  std::vector<std::pair<Statistic, double>> statistics;  ///< value in the statistic's unit
  Warnings warnings;                                     ///< of the data
};

/// The pupil that a task's light by GHS is computed in.
GhsPupil pupil_of_task(const Task& task);

/// The statistics that the task asks for, as make_targets gives them (but where lay_groundwork takes rays for
/// steep slopes, by the closed form), or, where it asks for none, ee50, ee80
/// and ee90 in the focus, scatter_rms and rms_height. Some milliseconds, where laying out a fit takes a
/// hundred times that: no model is chosen, nothing is held out, the band is not split. Theory `rays`, which
/// has no closed form, takes as long as there. Throws FieldError as make_targets does, and for a task without
/// roughness; ComputationError where the theory has no value. pupil_of: of its mirror, aperture and light,
/// where the caller has it: that is half of the time.
TheoryValues theory_values(const Task& task,
                           const std::function<GhsPupil(const Task&)>& pupil_of = pupil_of_task);

/// The theory of the task's targets as choose_physics has it, before slopes are found too steep for a closed
/// form. psd: of the specification.
Theory theory_of_targets(const Task& task, const RadialPsd& psd);

}  // namespace aberfit
