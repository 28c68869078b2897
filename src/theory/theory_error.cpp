#include "aberfit/theory/theory_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/theory/scattering_band.h"
#include "radial_transform.h"
#include "surface_transfer.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kWavelengthsOfTaper = 300;  // blurs edges of the angle by 1/(300 pi) rad: 0.06 degrees
constexpr double kTapersOfCutoff = 4;        // exp(-16) is left at the cutoff

// Fraction of the energy within the sine s of the specular direction, over v = 2 pi (cutoff/lambda) s.
RadialTransform scatter_of(const ScatteringBand& band, double wavelength) {
  const double cutoff = kTapersOfCutoff * kWavelengthsOfTaper * wavelength;
  const double g = 4 * std::numbers::pi * band.rms_height / wavelength, core = std::exp(-g * g);
  SurfaceTransferOptions options = transfer_options(band.psd, wavelength, cutoff, 0);
  options.breakpoints.push_back(cutoff);
  const SurfaceTransfer transfer = surface_transfer(
      [&](const Eigen::ArrayXd& x) { return surface_exponent(band.psd, wavelength, x); }, g * g, options);
  std::vector<TransferPanel> panels;
  for (TransferPanel panel : transfer.panels) {
    panel.value += core;
    append_product(
        panel, [](double s) { return std::exp(-std::pow(kTapersOfCutoff * s, 2)); }, &panels);
  }
  return RadialTransform(std::move(panels));
}

}  // namespace

TheoryError theory_error(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         double wavelength) {
  if (!std::isfinite(structure_function(psd, Eigen::ArrayXd::Constant(1, wavelength))[0]))
    throw ComputationError("the structure function of this PSD is infinite; give the PSD a lowest frequency");
  const ScatteringBand band = scattering_band(psd, wavelength);
  TheoryError error;
  error.cut_share = band.cut_share;
  error.paraxial = std::pow(aperture_radius(aperture) / mirror.focal_length, 2) / 8;
  const RadialTransform scatter = scatter_of(band, wavelength);
  const double per_sine = 2 * std::numbers::pi * kTapersOfCutoff * kWavelengthsOfTaper;
  const auto within = [&](double sine) { return scatter.disc(per_sine * sine).share; };
  error.beyond_ten_degrees = std::max(0.0, 1 - within(std::sin(std::numbers::pi / 18)));
  // 90 % of the scattered energy; the core fills the middle of the taper's width.
  const double g = 4 * std::numbers::pi * band.rms_height / wavelength;
  const double wanted = 1 + 0.1 * std::expm1(-g * g);
  double low = 0, high = 1;
  if (within(1) < wanted) {
    error.small_angle = kInfinity;
  } else {
    for (int i = 0; i < 40; ++i) (within(0.5 * (low + high)) < wanted ? low : high) = 0.5 * (low + high);
    error.small_angle = 0.5 * high * high;
  }
  error.applies = error.beyond_ten_degrees <= kTooMuchBeyondTenDegrees;
  error.wide_angles = error.applies && error.beyond_ten_degrees > kMostBeyondTenDegrees;
  error.mostly_grazing = wavelength < kShortestAtNormalIncidence;
  if (!error.applies)
    error.clause = fmt::format(
        "the roughness scatters {:.3g} % of the energy beyond 10 degrees (at most {:.3g} % is possible), "
        "where scalar Harvey-Shack theory does not apply",
        100 * error.beyond_ten_degrees, 100 * kTooMuchBeyondTenDegrees);
  else if (error.wide_angles)
    error.clause = fmt::format(
        "the roughness scatters {:.2g} % of the energy beyond 10 degrees, where scalar theory neglects "
        "obliquity and polarisation. Encircled energies may be wrong by {:.1g} % of the energy; a lower "
        "f_max or a longer wavelength reduces this",
        100 * error.beyond_ten_degrees, 100 * kObliquity * error.beyond_ten_degrees);
  if (error.mostly_grazing)
    error.of_grazing =
        "mirrors for wavelengths below 30 nm are mostly used at grazing incidence, but this theory is for "
        "normal incidence";
  return error;
}

double ray_error_in_light(const GeneralisedHarveyShack& light, const GeometricHarveyShack& rays,
                          const std::vector<double>& fractions, const std::vector<double>& planes) {
  double worst = 0;
  for (const double dz : planes) {
    const MeanSpot spot = light.at_plane(dz);
    for (const double p : fractions) {
      const double radius = spot.encircled_energy_radius(p);
      if (!std::isfinite(radius)) return kInfinity;
      const double slope = std::max(radius * spot.encircled_energy_slope(radius), kFlattestCurve);
      worst = std::max(worst, std::abs(rays.encircled_energy(radius, dz) - p) / slope);
    }
  }
  return worst;
}

}  // namespace aberfit
