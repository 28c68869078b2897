#include "aberfit/theory/model_choice.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"

namespace aberfit {
namespace {

ModelRadii radii(const GeneralisedHarveyShack& model) {
  const MeanSpot spot = model.at_plane(0);
  return {spot.encircled_energy_radius(0.5), spot.encircled_energy_radius(0.9),
          spot.encircled_energy_radius(0.8)};
}

}  // namespace

ModelErrors model_errors(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength) {
  ModelErrors errors;
  errors.ghs = radii(GeneralisedHarveyShack(psd, mirror, aperture, wavelength));
  const double slope = psd_moments(psd).rms_slope_per_axis();
  if (std::isfinite(slope)) {
    const GeometricHarveyShack rays(mirror, aperture, slope, Convention::kPhysical, 0);
    errors.rays = {rays.encircled_energy_radius(0.5, 0), rays.encircled_energy_radius(0.9, 0),
                   rays.encircled_energy_radius(0.8, 0)};
  } else {
    errors.rays = {kInfinity, kInfinity, kInfinity};
  }
  errors.ray_ee50 = errors.rays.ee50 / errors.ghs.ee50 - 1;
  errors.ray_ee90 = errors.rays.ee90 / errors.ghs.ee90 - 1;
  return errors;
}

ModelChoice choose_model(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength) {
  const SceneNumbers numbers = scene_numbers(psd, mirror, aperture, wavelength);
  ModelChoice choice;
  if (!std::isfinite(numbers.kappa)) {
    choice.errors = {{kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}, kNaN, kNaN};
    choice.reason = numbers.reason;
    return choice;
  }
  const ModelErrors& e = choice.errors = model_errors(psd, mirror, aperture, wavelength);
  const bool rays_agree = std::abs(e.ray_ee50) <= kErrorOfRays && std::abs(e.ray_ee90) <= kErrorOfRays;
  if (numbers.rays_are_valid && rays_agree) {
    choice.model = FocusModel::kRays;
    choice.reason = fmt::format(
        "kappa = {:.3g} is at least {} and geometric rays meet wave optics within {:.1f} % (ee50) and {:.1f} "
        "% (ee90): "
        "geometric rays are the right model.",
        numbers.kappa, kKappaOfRays, 100 * std::abs(e.ray_ee50), 100 * std::abs(e.ray_ee90));
  } else if (numbers.kappa >= kKappaOfRays) {
    choice.reason = fmt::format(
        "kappa = {:.3g} is at least {}, but geometric rays err by {:+.1f} % (ee50) and {:+.1f} % (ee90) on a "
        "spot of {:.3g} Airy ee90: wave optics is needed.",
        numbers.kappa, kKappaOfRays, 100 * e.ray_ee50, 100 * e.ray_ee90, e.ghs.ee90 / numbers.airy_ee90);
  } else {
    choice.reason = numbers.reason;
  }
  return choice;
}

}  // namespace aberfit
