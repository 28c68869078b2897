#include "aberfit/theory/regime.h"

#include <fmt/format.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/root.h"
#include "aberfit/core/units.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/theory/aperture_otf.h"
#include "aberfit/theory/scattering_band.h"
#include "surface_transfer.h"

namespace aberfit {
namespace {

constexpr double kAiryEe90 = 1.9006879778302467;  // full circle: root of J0^2 + J1^2 = 0.1, over pi

constexpr boost::math::policies::policy<boost::math::policies::promote_double<false>> kInDouble;

// ee90 of a perfect aperture over lambda f [1/m], from EE(a) = 2 pi a int OTF(x) J1(2 pi a x) dx.
double perfect_ee90(const ApertureOtf& otf) {
  constexpr int kNodes = 64;
  constexpr double kEe90Tolerance = 1e-13;
  const Quadrature rule = gauss_legendre(kNodes, 0.0, 1.0);
  std::vector<double> shear, weight;
  double low = 0;
  for (const double high : otf.breakpoints()) {
    // Pieces of the OTF end in half powers; x = 3 t^2 - 2 t^3 turns them into whole powers.
    for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
      const double t = rule.nodes[i];
      shear.push_back(low + (high - low) * t * t * (3 - 2 * t));
      weight.push_back(rule.weights[i] * (high - low) * 6 * t * (1 - t) * otf(shear.back()));
    }
    low = high;
  }
  const auto energy = [&](double a) {
    double sum = 0;
    for (std::size_t i = 0; i < shear.size(); ++i)
      sum += weight[i] * boost::math::cyl_bessel_j(1, 2 * std::numbers::pi * a * shear[i], kInDouble);
    return 2 * std::numbers::pi * a * sum;
  };
  double inside = 0, outside = 1 / otf.cutoff();
  while (energy(outside) < 0.9) inside = outside, outside *= 1.5;
  return root_between([&](double a) { return energy(a) - 0.9; }, inside, outside, energy(inside) - 0.9,
                      energy(outside) - 0.9, kEe90Tolerance);
}

std::string length(double metres) { return format_quantity(metres, Dimension::kLength); }

std::string explain(const SceneNumbers& n, double ray_ee90) {
  if (n.rms_height == 0) return "The surface is perfectly smooth, so there is no scatter to model by rays.";
  if (!std::isfinite(n.rms_height) && !std::isfinite(n.kappa))
    return "The height variance of this PSD is infinite (its integral diverges at low frequency), and so is "
           "its structure function. Then g, the autocorrelation and kappa do not exist, and rays cannot be "
           "justified. Give the PSD a lowest frequency.";
  if (!std::isfinite(n.rms_height) && n.kappa < kKappaOfRays)
    return fmt::format(
        "The height variance of this PSD is infinite (its integral diverges at low frequency), so g does not "
        "exist. From its structure function kappa = {:.3g} is below {}, so wave optics is needed and rays "
        "are wrong.",
        n.kappa, kKappaOfRays);
  if (!std::isfinite(n.rms_slope_per_axis))
    return fmt::format(
        "The slope variance of this PSD is infinite (the slope integral diverges at high frequency), so "
        "surface slopes, rays and "
        "kappa do not exist; rms height {} gives g = {:.3g}.",
        length(n.rms_height), n.g);
  if (n.kappa < kKappaOfRays)
    return fmt::format(
        "kappa = {:.3g} is below {} (g = {:.3g}): the surface is too smooth or its spectrum too wide for "
        "slopes to determine the focus, so wave optics is needed and rays are wrong.",
        n.kappa, kKappaOfRays, n.g);
  if (ray_ee90 < kAiryRadiiForRays * n.airy_ee90)
    return fmt::format(
        "kappa = {:.3g} is at least {}, but the ray ee90 of {} is only {:.3g} times the Airy ee90 of {} "
        "(below {}). Diffraction, which rays leave out, is visible, so wave optics is needed.",
        n.kappa, kKappaOfRays, length(ray_ee90), ray_ee90 / n.airy_ee90, length(n.airy_ee90),
        kAiryRadiiForRays);
  return fmt::format(
      "kappa = {:.3g} is at least {} and the ray ee90 of {} is {:.3g} times the Airy ee90 of {} (at least "
      "{}), so geometric rays are the right model.",
      n.kappa, kKappaOfRays, length(ray_ee90), ray_ee90 / n.airy_ee90, length(n.airy_ee90),
      kAiryRadiiForRays);
}

}  // namespace

double airy_ee90(const Mirror& mirror, const Aperture& aperture, double wavelength) {
  const double waves = wavelength * mirror.focal_length;
  if (std::holds_alternative<CircleAperture>(aperture))
    return kAiryEe90 * waves / (2.0 * aperture_radius(aperture));
  return perfect_ee90(ApertureOtf(aperture)) * waves;
}

FocusModel regime(const SceneNumbers& numbers) {
  return numbers.kappa_rule_allows_rays ? FocusModel::kRays : FocusModel::kWaves;
}

SceneNumbers scene_numbers(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                           double wavelength) {
  const PsdMoments moments = psd_moments(psd);
  const double diameter = 2.0 * aperture_radius(aperture);
  SceneNumbers n;
  n.rms_height = moments.rms_height();
  n.rms_slope_per_axis = moments.rms_slope_per_axis();
  const ScatteringBand band = scattering_band(psd, wavelength);
  n.relevant_rms_height = band.rms_height;
  n.cut_share = band.cut_share;
  n.g = 4.0 * std::numbers::pi * n.relevant_rms_height / wavelength;
  n.tis = -std::expm1(-n.g * n.g);
  n.airy_ee90 = airy_ee90(mirror, aperture, wavelength);
  if (n.rms_height > 0) {
    if (std::isfinite(n.rms_height)) {
      n.correlation_length = correlation_length(psd);
      n.paper_ratio_r = 2.0 * n.rms_height * diameter / (1.22 * wavelength * n.correlation_length);
    }
    if (!std::isfinite(structure_function(psd, Eigen::ArrayXd::Constant(1, diameter))[0])) n.kappa = kNaN;
    // Without a slope variance x1 is 0, where E is 0. So kappa stays 0, and so does n_eff, whose two
    // integrals diverge. Without a height variance E is half the phase's structure function.
    if (std::isfinite(n.rms_slope_per_axis)) {
      n.n_eff = effective_modes(moments, aperture_area(aperture));
      const double x1 = std::numbers::sqrt2 * wavelength / (4.0 * std::numbers::pi * n.rms_slope_per_axis);
      n.kappa = internal::surface_exponent(band.psd, wavelength, Eigen::ArrayXd::Constant(1, x1))[0];
    }
  }
  const double ray_ee90 = kGaussianEe90 * 2.0 * mirror.focal_length * n.rms_slope_per_axis;
  n.kappa_rule_allows_rays =
      n.kappa >= kKappaOfRays && std::isfinite(ray_ee90) && ray_ee90 >= kAiryRadiiForRays * n.airy_ee90;
  n.reason = explain(n, ray_ee90);
  return n;
}

}  // namespace aberfit
