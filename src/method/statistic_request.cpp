#include "statistic_request.h"

#include <cassert>
#include <cmath>
#include <numbers>
#include <string>
#include <variant>

#include "aberfit/core/constants.h"

namespace aberfit::internal {
namespace {

// "ee50" -> 0.5
double fraction_of(const std::string& name) { return std::stod(name.substr(2)) / 100; }

std::vector<Wanted> profile(const StatisticRequest& request, const RingOf& ring_of) {
  const auto* given = std::get_if<double>(&request.ring);
  const double ring = given ? *given : ring_of(fraction_of(std::get<std::string>(request.ring)));
  std::vector<Wanted> wanted;
  for (std::size_t k = 0; k < request.profile_dz.size(); ++k)
    wanted.push_back({RingThrough{ring, request.profile_dz[k], true}, request.profile_value[k],
                      request.standard_error, request.tolerance});
  return wanted;
}

RingFwhm ring_of_width(const StatisticRequest& request) {
  RingFwhm ring;
  if (const auto* radius = std::get_if<double>(&request.ring))
    ring.ring_radius = *radius;
  else
    ring.ring_fraction = fraction_of(std::get<std::string>(request.ring));
  return ring;
}

}  // namespace

std::vector<Wanted> wanted_by(const StatisticRequest& request, const RingOf& ring_of, double focal_sigma) {
  const std::string& name = request.name;
  if (name == "ring_profile") return profile(request, ring_of);
  std::vector<Wanted> wanted;
  const auto add = [&](const Statistic& statistic) {
    wanted.push_back({statistic, request.value, request.standard_error, request.tolerance, request.asked});
  };
  if (name == "ring_fwhm") add(ring_of_width(request));
  if (name == "scatter_rms") add(ScatterRms{});
  if (name == "scatter_mean") add(ScatterMean{});
  if (name == "spot_fwhm") add(SpotFwhm{request.bandwidth.value_or(0.1 * focal_sigma)});
  if (name == "rms_height") add(RmsHeight{});
  if (name == "strehl") add(StrehlRatio{});
  if (name == "mtf")
    for (const double frequency : request.frequencies) add(ModulationTransfer{frequency});
  if (kind_of_key(name).in_planes)
    for (const double dz : request.planes) {
      if (name == "ee_within")
        for (const double radius : request.radii) add(RingThrough{radius, dz});
      else if (name == "ensquared_within")
        for (const double side : request.sides) add(EnsquaredThrough{side, dz});
      else if (name == "rms_radius")
        add(RmsRadius{dz});
      else
        add(EncircledEnergyRadius{fraction_of(name), dz});
    }
  assert(!wanted.empty());  // a kind without a line above
  return wanted;
}

std::optional<double> spot_sigma(const StatisticRequest& request, double focal_length) {
  const std::string& name = request.name;
  const auto* ring = std::get_if<double>(&request.ring);
  if (ring && (name == "ring_fwhm" || name == "ring_profile")) return *ring / kGaussianEe90;
  const double value = request.value.value_or(0);
  if (!(value > 0)) return std::nullopt;
  if (name == "rms_radius") return value / std::numbers::sqrt2;
  if (name == "scatter_rms") return value * focal_length / std::numbers::sqrt2;
  if (name == "scatter_mean") return value * focal_length / std::sqrt(0.5 * kPi);
  if (name == "spot_fwhm") return value / std::sqrt(8 * std::numbers::ln2);
  if (name == "ensquared_within" && request.planes.front() == 0)
    return gaussian_sigma(request.sides.front() / std::sqrt(kPi), value);
  if (!name.starts_with("ee") || request.planes.front() != 0) return std::nullopt;
  if (name == "ee_within") return gaussian_sigma(request.radii.front(), value);
  return gaussian_sigma(value, fraction_of(name));
}

}  // namespace aberfit::internal
