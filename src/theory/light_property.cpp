#include "aberfit/theory/light_property.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/theory/aberrated_light.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

namespace {

constexpr double kNoHeights = 1e-9;  // in wavelengths: scatters 2e-16 of the energy

}  // namespace

double LightProperties::r0_of(const PointSourceSensitivity& property) const {
  return property.r0 * std::pow(wavelength_ / kWavelengthOfR0, 6.0 / 5);
}

LightProperties::LightProperties(std::vector<LightProperty> wanted, const GhsPupil& pupil)
    : wanted_(std::move(wanted)), perfect_(wanted_.size(), 1), wavelength_(pupil.wavelength()) {
  std::optional<MeanSpot> parabola;
  for (std::size_t k = 0; k < wanted_.size(); ++k) {
    const auto* air = std::get_if<PointSourceSensitivity>(&wanted_[k]);
    if (!air && !std::holds_alternative<StrehlRatio>(wanted_[k])) continue;
    if (!air && pupil.has_uneven_light()) {
      if (!aberrated_) aberrated_ = std::make_shared<const AberratedLight>(pupil);
      continue;
    }
    if (!parabola) {
      const RadialPsd smooth(GaussianPsd{kNoHeights * wavelength_, aperture_radius(pupil.aperture())});
      parabola = GeneralisedHarveyShack(smooth, pupil.of_parabola()).at_plane(0);
    }
    perfect_[k] = air ? parabola->seen_through_air(*parabola, r0_of(*air)) : parabola->irradiance(0);
  }
}

// Without aberrations the transfer function is nowhere negative, so the irradiance is highest on the axis.
double LightProperties::strehl(std::size_t k, const GeneralisedHarveyShack& mean) const {
  if (aberrated_) return aberrated_->peak(mean.psd()).strehl;
  const MeanSpot focus = mean.at_plane(0);
  return focus.irradiance(mean.departs() ? focus.highest_radius() : 0) / perfect_[k];
}

double LightProperties::value(std::size_t k, const GeneralisedHarveyShack& mean) const {
  return std::visit(
      Overloaded{
          [&](const StrehlRatio&) { return strehl(k, mean); },
          [&](const TotalScatter&) { return mean.tis(); },
          [&](const ModulationTransfer& p) { return std::abs(mean.at_plane(0).transfer(p.frequency)); },
          [&](const EnsquaredSide& p) { return mean.at_plane(p.dz).ensquared_side(p.fraction); },
          [&](const IrradianceFwhm& p) { return mean.at_plane(p.dz).fwhm(); },
          [&](const PointSourceSensitivity& p) {
            const MeanSpot spot = mean.at_plane(0);
            return spot.seen_through_air(spot, r0_of(p)) / perfect_[k];
          },
          // Rounding may leave values below zero far beyond the band.
          [&](const PatchBsdf& p) {
            return std::max(0.0, ScatterFunction(mean.psd(), wavelength_).bsdf(p.theta));
          }},
      wanted_[k]);
}

Eigen::VectorXd LightProperties::operator()(const GeneralisedHarveyShack& mean) const {
  Eigen::VectorXd values(Eigen::Index(wanted_.size()));
  for (std::size_t k = 0; k < wanted_.size(); ++k) values[Eigen::Index(k)] = value(k, mean);
  return values;
}

}  // namespace aberfit
