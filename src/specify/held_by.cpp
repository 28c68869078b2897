#include "held_by.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/root.h"
#include "aberfit/method/tost.h"
#include "aberfit/theory/realisation_spread.h"

namespace aberfit::internal {
namespace {

// Radii relative to the mean radius at which the spread is evaluated; linear in between.
constexpr std::array kRadii = {1.0, 1.05, 1.12, 1.25, 1.45, 1.8, 2.4, 3.5};
constexpr double kRoot = 1e-10;  // relative, of the radius

double between(const Eigen::ArrayXd& sigma, double factor) {
  std::size_t k = 1;
  while (k + 1 < kRadii.size() && kRadii[k] < factor) ++k;
  const double t = std::clamp((factor - kRadii[k - 1]) / (kRadii[k] - kRadii[k - 1]), 0.0, 1.0);
  return (1 - t) * sigma[Eigen::Index(k) - 1] + t * sigma[Eigen::Index(k)];
}

// Radius where the mean encircled energy less (at_most) or plus `deviations` standard deviations is the
// fraction.
double radius_held(const MeanSpot& spot, const EncircledEnergyRadius& energy, double mean_radius,
                   const Eigen::ArrayXd& sigma, double deviations, bool at_most) {
  const double way = at_most ? 1 : -1;
  const auto missing = [&](double log) {  // increases with the distance from the mean radius
    const double factor = std::exp(log), radius = mean_radius * (at_most ? factor : 1 / factor);
    return way * (spot.encircled_energy(radius) - energy.fraction) - deviations * between(sigma, factor);
  };
  const double furthest = std::log(kRadii.back());
  const double at_mean = missing(0), far = missing(furthest);
  if (!(at_mean < 0)) return mean_radius;
  if (!(far > 0)) return at_most ? kInfinity : mean_radius / kRadii.back();
  // The root is sought in t = 1 + log, so that a relative tolerance applies to the radius.
  const double log =
      root_between([&](double t) { return missing(t - 1); }, 1, 1 + furthest, at_mean, far, kRoot) - 1;
  return mean_radius * std::exp(way * log);
}

}  // namespace

Eigen::VectorXd held_by(double confidence, const ManyMirrors& mirrors, const Eigen::VectorXd& of_mean) {
  const double deviations = student_quantile(confidence, kInfinity);
  const double furthest = 0.95 * mirrors.pupil.mirror().focal_length;
  std::vector<FocalDisc> discs;
  std::vector<int> first(mirrors.budgets.size(), -1);
  for (std::size_t k = 0; k < mirrors.budgets.size(); ++k) {
    const auto* energy = std::get_if<EncircledEnergyRadius>(&mirrors.budgets[k].statistic);
    const double radius = of_mean[Eigen::Index(k)];
    if (!energy || !(radius < furthest)) continue;
    first[k] = int(discs.size());
    for (const double factor : kRadii)
      discs.push_back(
          {std::min(mirrors.budgets[k].at_most ? radius * factor : radius / factor, furthest), energy->dz});
  }
  const RealisationSpread spread({mirrors.psd, mirrors.pupil.mirror(), mirrors.pupil.aperture(),
                                  mirrors.pupil.wavelength(), mirrors.mean},
                                 discs);
  const Eigen::ArrayXd light = spread.light(spread.lowest());
  Eigen::VectorXd held = of_mean;
  for (std::size_t k = 0; k < mirrors.budgets.size(); ++k) {
    const Budget& budget = mirrors.budgets[k];
    double& value = held[Eigen::Index(k)];
    if (const auto* energy = std::get_if<EncircledEnergyRadius>(&budget.statistic)) {
      if (first[k] >= 0)
        value = radius_held(mirrors.mean.at_plane(energy->dz), *energy, value,
                            light.segment(first[k], Eigen::Index(kRadii.size())), deviations, budget.at_most);
      continue;
    }
    const double relative = std::holds_alternative<RmsHeight>(budget.statistic)
                                ? spread.rms_height(spread.lowest())
                                : spread.rms_slope(spread.lowest());
    value *= std::max(0.0, 1 + (budget.at_most ? 1 : -1) * deviations * relative);
  }
  return held;
}

}  // namespace aberfit::internal
