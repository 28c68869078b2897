#include "aberfit/theory/model_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/theory_error.h"

namespace aberfit {
namespace {

template <class Theory>
ModelRadii radii(const Theory& model) {
  const auto holding = [&](double fraction) { return model.encircled_energy_radius(fraction, 0); };
  return {holding(0.5), holding(0.9), holding(0.8)};
}

// Both theories of a scene; no rays where the slope is infinite.
struct Theories {
  GeneralisedHarveyShack light;
  std::optional<GeometricHarveyShack> rays;

  Theories(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture, double wavelength)
      : light(psd, mirror, aperture, wavelength) {
    const double slope = psd_moments(psd).rms_slope_per_axis();
    if (std::isfinite(slope)) rays.emplace(mirror, aperture, slope, Convention::kPhysical, 0);
  }
};

ModelErrors errors_of(const Theories& theories) {
  ModelErrors errors;
  errors.ghs = radii(theories.light);
  errors.rays = theories.rays ? radii(*theories.rays) : ModelRadii{kInfinity, kInfinity, kInfinity};
  errors.ray_ee50 = errors.rays.ee50 / errors.ghs.ee50 - 1;
  errors.ray_ee90 = errors.rays.ee90 / errors.ghs.ee90 - 1;
  return errors;
}

// The default fractions and planes that decide; planes in depths of focus f sigma_f / R.
const std::vector<double> kFractions = {0.20, 0.35, 0.50, 0.65, 0.80, 0.90, 0.95};
constexpr double kPlanes[] = {0, -1, 1, -2.5, 2.5, -5, 5};

double error_of_rays(const Theories& theories, const Mirror& mirror, const Aperture& aperture,
                     double ghs_ee90, double allowed) {
  if (!theories.rays || !std::isfinite(ghs_ee90)) return kInfinity;
  const double depth =
      std::min(ghs_ee90 / kGaussianEe90 / aperture_radius(aperture), kDeepestUnit) * mirror.focal_length;
  double worst = 0;
  for (const double plane : kPlanes) {
    worst = std::max(worst, ray_error_in_light(theories.light, *theories.rays, kFractions, {plane * depth}));
    if (!(worst <= allowed)) break;
  }
  return worst;
}

}  // namespace

ModelChoice choose_model(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength, double allowed) {
  ModelChoice choice;
  choice.allowed = allowed;
  std::optional<Theories> theories;
  try {
    theories.emplace(psd, mirror, aperture, wavelength);
    choice.errors = errors_of(*theories);
  } catch (const ComputationError& e) {
    choice.errors = {{kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}, kNaN, kNaN};
    choice.ray_error = kNaN;
    choice.reason = fmt::format("Wave optics has no prediction here to compare rays with: {}.", e.what());
    return choice;
  }
  choice.ray_error = error_of_rays(*theories, mirror, aperture, choice.errors.ghs.ee90, allowed);
  if (choice.ray_error <= allowed) {
    choice.model = FocusModel::kRays;
    choice.reason = fmt::format(
        "Geometric rays agree with wave optics within {:.2g} %, which is at most the allowed {:.2g} %, so "
        "rays suffice.",
        100 * choice.ray_error, 100 * allowed);
  } else {
    choice.reason = fmt::format(
        "Geometric rays differ from wave optics by {} (ee50 {:+.1f} %, ee90 {:+.1f} %), more than the "
        "allowed {:.2g} %, so wave optics is needed.",
        std::isfinite(choice.ray_error) ? fmt::format("{:.2g} %", 100 * choice.ray_error) : "infinitely",
        100 * choice.errors.ray_ee50, 100 * choice.errors.ray_ee90, 100 * allowed);
  }
  return choice;
}

}  // namespace aberfit
