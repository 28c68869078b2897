#include "aberfit/specify/budget_light.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/parallel.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {
namespace {

constexpr double kNoRoughness = 1e-9;  // fraction of the heights; scatters 1e-18 of the energy

Eigen::ArrayXd encircled_energy(const GeneralisedHarveyShack& spot, const Eigen::ArrayXd& radius,
                                int threads) {
  const MeanSpot focus = spot.at_plane(0);
  Eigen::ArrayXd fraction(radius.size());
  parallel_for(std::size_t(radius.size()), threads, [&](std::size_t k) {
    fraction[Eigen::Index(k)] = focus.encircled_energy(radius[Eigen::Index(k)]);
  });
  return fraction;
}

}  // namespace

double budgeted_radius(const Budget& budget, double focal_length) {
  const auto* energy = std::get_if<EncircledEnergyRadius>(&budget.statistic);
  if (!energy || energy->dz != 0 || budget.of_light || budget.of_surface) return std::nan("");
  const double length = budget.limit * (budget.dimension == Dimension::kAngle ? focal_length : 1);
  return budget.is_diameter ? 0.5 * length : length;
}

BudgetLight budget_light(const TaskAt& task_at, const Specification& spec, int threads) {
  constexpr Eigen::Index kPoints = 300;
  BudgetLight light;
  if (spec.theory != Theory::kGhs) return light;
  const Task start = task_at(spec.start.at);
  const GhsPupil pupil(start.mirror, start.aperture, start.wavelength);
  const RadialPsd psd(*start.psd);
  const GeneralisedHarveyShack study(psd, pupil);
  const MeanSpot focus = study.at_plane(0);
  double low = focus.encircled_energy_radius(0.1), high = focus.encircled_energy_radius(0.95);
  for (const Budget& budget : spec.budgets)
    if (const double radius = budgeted_radius(budget, spec.focal_length); std::isfinite(radius))
      low = std::min(low, 0.1 * radius), high = std::max(high, 3 * radius);
  if (!(low > 0) || !std::isfinite(high)) return light;
  light.radius = Eigen::ArrayXd::LinSpaced(kPoints, std::log(low), std::log(high)).exp();
  light.study = encircled_energy(study, light.radius, threads);
  light.perfect =
      encircled_energy(GeneralisedHarveyShack(psd.scaled(kNoRoughness), pupil), light.radius, threads);
  if (!spec.solutions.empty())
    light.solution =
        encircled_energy(GeneralisedHarveyShack(RadialPsd(*task_at(spec.solutions.front().at).psd), pupil),
                         light.radius, threads);
  return light;
}

}  // namespace aberfit
