#include "aberfit/method/theory_values.h"

#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/theory/height_on_aperture.h"
#include "statistic_request.h"

namespace aberfit {
using namespace internal;

namespace {

// The theory with a closed form that gives a task's targets.
struct ClosedForm {
  std::optional<GeneralisedHarveyShack> light;
  std::optional<GeometricHarveyShack> rays;

  double radius(double fraction) const {
    return light ? light->encircled_energy_radius(fraction, 0) : rays->encircled_energy_radius(fraction, 0);
  }
  Eigen::VectorXd predict(const std::vector<Statistic>& statistics) const {
    if (light) return light->predict(statistics);
    Eigen::VectorXd values(Eigen::Index(statistics.size()));
    for (std::size_t k = 0; k < statistics.size(); ++k) values[Eigen::Index(k)] = (*rays)(statistics[k]);
    return values;
  }
  // Scale of the spot as in lay_groundwork [m].
  double sigma() const {
    if (!light) return rays->focal_sigma();
    const double ee90 = radius(0.9);
    return std::isfinite(ee90) ? ee90 / kGaussianEe90 : rays->focal_sigma();
  }
};

std::vector<Wanted> wanted_of(const Task& task, const ClosedForm& theory) {
  if (task.target.statistics.empty())
    return {{EncircledEnergyRadius{0.5, 0}},
            {EncircledEnergyRadius{0.8, 0}},
            {EncircledEnergyRadius{0.9, 0}},
            {ScatterRms{}},
            {RmsHeight{}}};
  std::vector<Wanted> wanted;
  const double sigma = theory.sigma();
  for (const StatisticRequest& request : task.target.statistics)
    for (const Wanted& of : wanted_by(
             request, [&](double fraction) { return theory.radius(fraction); }, sigma))
      wanted.push_back(of);
  return wanted;
}

// Values without a closed form, computed as the targets of a fit.
void predict_as_targets(const Task& task, TheoryValues* values) {
  const Groundwork ground = lay_groundwork(task);
  const TargetSets targets = make_targets(task, ground, 1);
  values->theory = targets.theory;
  for (const Target& target : targets.fitted) values->statistics.emplace_back(target.statistic, target.value);
}

}  // namespace

GhsPupil pupil_of_task(const Task& task) { return {task.mirror, task.aperture, task.wavelength}; }

TheoryValues theory_values(const Task& task, const std::function<GhsPupil(const Task&)>& pupil_of) {
  if (!task.psd)
    throw FieldError("roughness", "nothing", "a roughness block, from which theory predicts the statistics");
  TheoryValues values;
  values.warnings = task.data_warnings;
  const RadialPsd psd(*task.psd);
  values.numbers = scene_numbers(psd, task.mirror, task.aperture, task.wavelength);
  if (!std::isfinite(values.numbers.rms_slope_per_axis))
    throw FieldError("roughness.psd", "a PSD whose slope variance is infinite",
                     "a band limit f_max, because rays need a finite slope");
  const Theory theory = theory_of_targets(task, psd);
  if (theory == Theory::kRays) {
    predict_as_targets(task, &values);
    return values;
  }
  ClosedForm closed;
  const bool in_light = theory == Theory::kGhs;  // then wave optics gives the heights, too
  closed.rays.emplace(task.mirror, task.aperture, values.numbers.rms_slope_per_axis, task.target.convention,
                      in_light ? kNaN : rms_height_on(task.aperture, psd));
  if (in_light) {
    closed.light.emplace(psd, pupil_of(task));
    values.numbers.tis = closed.light->tis();
  }
  const std::vector<Wanted> wanted = wanted_of(task, closed);
  std::vector<Statistic> statistics;
  for (const Wanted& one : wanted)
    if (!one.value) statistics.push_back(one.statistic);
  if (closed.light) refuse_without_rays(to_string(theory), statistics);
  const Eigen::VectorXd predicted = closed.predict(statistics);
  values.theory = statistics.empty() ? "given" : to_string(theory);
  Eigen::Index next = 0;
  for (const Wanted& one : wanted) {
    const double value = one.value ? *one.value : predicted[next++];
    if (!std::isfinite(value))
      throw ComputationError("the theory has no value for " + statistic_name(one.statistic) +
                             ", because there is no real focus");
    values.statistics.emplace_back(one.statistic, value);
  }
  return values;
}

}  // namespace aberfit
