// Statistics by theory: their means, how the means change with the PSD, and their spread among mirrors.
#include <cmath>
#include <map>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/parallel.h"
#include "aberfit/theory/aberrated_light.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/height_on_aperture.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/theory/realisation_spread.h"
#include "aberfit/theory/scatter_function.h"
#include "exact_transfer.h"
#include "radial_transform.h"

namespace aberfit {
using namespace internal;

namespace {

// Step of differences over the plane, relative to its distance from the peak. They are of eighth order. The
// error is 576 kPlaneStep^8 from truncation and 1e-11/kPlaneStep from rounding.
constexpr double kPlaneStep = 0.03;
constexpr double kPatchStep = 1e-3;  // step of ln p, for a patch and for pupils without symmetry

template <typename Theory>
double radius_of(const RingFwhm& ring, const Theory& mean) {
  return ring.ring_radius ? *ring.ring_radius : mean.encircled_energy_radius(ring.ring_fraction, 0.0);
}

// See deciding_disc.
struct DiscOfAim {
  using Disc = std::optional<DecidingDisc>;

  // A ray theory has no curve E(r). With the slope of the mean irradiance instead, the radius changes by the
  // energy in it over that slope.
  Disc operator()(const EncircledEnergyRadius& s) const {
    if (!(value > 0)) return {};
    return {{{value, s.dz}, relative_to * mean.at_plane(s.dz).encircled_energy_slope(value)}};
  }
  // The ring has the energy N(z); its width ends where N is half of its peak. To first order, a change of N
  // there moves the end by that change over the slope. For a mirror that departs from its parabola the
  // flatter end counts, and both ends are taken as independent.
  Disc operator()(const RingFwhm& s) const {
    const double radius = radius_of(s, mean);
    if (!std::isfinite(radius)) return {};
    const GeneralisedHarveyShack::RingPlanes planes = mean.ring_planes(radius);
    const double step = 0.02 * value;
    double end = planes.upper, slope = HUGE_VAL;
    for (const double plane : {planes.upper, planes.lower}) {
      const double here = std::abs(mean.encircled_energy(radius, plane + step) -
                                   mean.encircled_energy(radius, plane - step)) /
                          (2 * step);
      if (here < slope) slope = here, end = plane;
      if (!mean.departs()) break;  // both ends are alike
    }
    if (!std::isfinite(slope)) return {};
    const bool alike = !mean.departs();
    return {{{radius, end, alike}, value * slope / (alike ? 2.0 : std::sqrt(2.0))}};
  }
  Disc operator()(const RingThrough& s) const { return {{{s.ring_radius, s.dz}, relative_to}}; }
  Disc operator()(const EnsquaredThrough& s) const {
    return {{{s.side / std::sqrt(kPi), s.dz}, relative_to}};
  }
  // A Strehl ratio is the energy in a small disc, 0.2 lambda f/D, inside the top of the core. Where
  // aberrations move the peak off the axis, its relative spread is taken from the axis. This is the safe
  // side, because a lower irradiance has a larger relative spread.
  Disc operator()(const StrehlRatio&) const {
    const GhsPupil& pupil = mean.pupil();
    const double radius =
        0.2 * pupil.wavelength() * pupil.mirror().focal_length / (2 * aperture_radius(pupil.aperture()));
    return {{{radius, 0}, relative_to * mean.encircled_energy(radius, 0) / value}};
  }
  // Integration by parts gives MTF(nu) = int E(r) 2 pi nu J1(2 pi nu r) dr. A realisation changes E at all
  // radii nearly together, so only the first lobe of J1 counts: its top at 1.84, its integral 1 - J0(3.83) =
  // 1.40. Error: 1.05 to 1.99 times the spread of 60 realisations of four PSDs, at 0.08 to 0.5 of the cutoff
  // and Strehl ratios 0.85 to 1.04 (tests/method/light_statistics_test.cpp).
  Disc operator()(const ModulationTransfer& s) const {
    return {{{1.8412 / (kTwoPi * s.frequency), 0}, relative_to / 1.4028}};
  }
  Disc operator()(const SpotFwhm&) const { return {}; }
  Disc operator()(const RayKind auto&) const { return {}; }
  Disc operator()(const MomentKind auto&) const { return {}; }

  double value, relative_to;
  const GeneralisedHarveyShack& mean;
};

}  // namespace

double GeneralisedHarveyShack::operator()(const Statistic& statistic) const {
  return std::visit(
      Overloaded{
          [&](const EncircledEnergyRadius& s) { return encircled_energy_radius(s.fraction, s.dz); },
          [&](const RingFwhm& s) { return ring_fwhm(radius_of(s, *this)); },
          [&](const RingThrough& s) { return encircled_energy(s.ring_radius, s.dz); },
          [&](const ScatterRms&) { return scatter_rms(); },
          [&](const ScatterMean&) { return scatter_mean(); },
          [&](const SpotFwhm& s) { return spot_fwhm(s.bandwidth); },
          [&](const RmsRadius&) -> double {
            throw ComputationError(
                "the RMS radius of a diffracted spot does not exist, because its second moment diverges; "
                "request encircled-energy radii, or take theory geometric");
          },
          [&](const RmsHeight&) { return rms_height_on(aperture_, whole_); },
          [&](const EnsquaredThrough& s) { return at_plane(s.dz).ensquared_energy(s.side); },
          [&](const StrehlRatio& s) { return LightProperties({s}, pupil_)(*this)[0]; },
          [&](const ModulationTransfer& s) { return LightProperties({s}, pupil_)(*this)[0]; }},
      statistic);
}

double GeometricHarveyShack::operator()(const Statistic& statistic) const {
  return std::visit(
      Overloaded{[&](const EncircledEnergyRadius& s) { return encircled_energy_radius(s.fraction, s.dz); },
                 [&](const RingFwhm& s) { return ring_fwhm(radius_of(s, *this)); },
                 [&](const RingThrough& s) { return encircled_energy(s.ring_radius, s.dz); },
                 [&](const ScatterRms&) { return scatter_rms(); },
                 [&](const ScatterMean&) { return scatter_mean(); },
                 [&](const SpotFwhm& s) { return spot_fwhm(s.bandwidth); },
                 [&](const RmsRadius& s) { return rms_radius(s.dz); },
                 [&](const RmsHeight&) { return rms_height_; },
                 [&](const WaveKind auto&) -> double {
                   throw ComputationError(
                       statistic_name(statistic) +
                       " needs wave optics and does not exist for geometric rays; take theory ghs");
                 }},
      statistic);
}

std::optional<DecidingDisc> deciding_disc(const Target& aim, const GeneralisedHarveyShack& mean) {
  const auto disc = std::visit(DiscOfAim{aim.value, aim.relative_to(), mean}, aim.statistic);
  const bool exists = disc && disc->disc.radius > 0 && std::isfinite(disc->disc.radius) && disc->unit > 0;
  return exists ? disc : std::nullopt;
}

double RealisationSpread::of_moment(const Statistic& moment, double cut) const {
  return std::visit(Overloaded{[&](const RmsHeight&) { return rms_height(cut); },
                               [&](const ScatterRms&) { return rms_slope(cut); },
                               [&](const ScatterMean&) { return rms_slope(cut); },
                               [](const NoMoment auto&) { return kNaN; }},
                    moment);
}

/// Derivatives for one PSD and parameter p, over ln p: they are of the order of the statistic.
class JacobianOfGhs {
 public:
  JacobianOfGhs(const GeneralisedHarveyShack& ghs, const PsdModel& model, const PsdVariable& parameter)
      : ghs_(ghs),
        model_(model),
        parameter_(parameter),
        derivative_(model, parameter),
        scale_(value_of(model, parameter)) {}

  /// d(property)/d ln p of property k, whose value is `value`.
  double of_light(const LightProperties& light, std::size_t k, double value) {
    if (!std::isfinite(value)) return kNaN;
    const double perfect = light.perfect_[k];
    return std::visit(Overloaded{[&](const StrehlRatio&) { return of_strehl(value); },
                                 [&](const TotalScatter&) { return -ghs_.core_change(derivative_, scale_); },
                                 [&](const ModulationTransfer& p) { return of_transfer(p.frequency); },
                                 [&](const EnsquaredSide& p) {
                                   return -change(p.dz).ensquared_energy(value) /
                                          ghs_.at_plane(p.dz).ensquared_energy_slope(value);
                                 },
                                 [&](const IrradianceFwhm& p) { return of_fwhm(p.dz, value); },
                                 [&](const PointSourceSensitivity& p) {
                                   return 2 * ghs_.at_plane(0).seen_through_air(change(0), light.r0_of(p)) /
                                          perfect;
                                 },
                                 [&](const PatchBsdf& p) { return of_patch(p); }},
                      light.wanted_[k]);
  }

  /// d(statistic)/d ln p of a statistic, whose value is `value`.
  double operator()(const Statistic& statistic, double value) {
    if (!std::isfinite(value)) return kNaN;
    return std::visit(
        Overloaded{[&](const EncircledEnergyRadius& s) { return of_radius(value, s.dz); },
                   [&](const RingFwhm& s) { return of_ring(s); },
                   [&](const RingThrough& s) { return change(s.dz).encircled_energy(s.ring_radius); },
                   [&](const ScatterRms&) { return value * of_slope(); },
                   [&](const ScatterMean&) { return value * of_slope(); },
                   [&](const SpotFwhm& s) { return of_spot(s.bandwidth, value); },
                   [&](const RmsRadius&) { return kNaN; },
                   [&](const RmsHeight&) {
                     return scale_ * height_variance_change_on(ghs_.aperture_, ghs_.whole_, derivative_) /
                            (2 * value);
                   },
                   [&](const StrehlRatio&) { return of_strehl(value); },
                   [&](const ModulationTransfer& s) { return of_transfer(s.frequency); },
                   [&](const EnsquaredThrough& s) { return change(s.dz).ensquared_energy(s.side); }},
        statistic);
  }

 private:
  const GeneralisedHarveyShack::SurfaceChange& surface() {
    if (surface_.empty()) surface_ = ghs_.change_of(derivative_, scale_);
    return surface_;
  }
  const MeanSpot& change(double dz) {
    const auto known = planes_.find(dz);
    return known != planes_.end() ? known->second
                                  : planes_.emplace(dz, ghs_.change_at_plane(surface(), dz)).first->second;
  }
  // d ln(slope)/d ln p.
  double of_slope() const {
    return scale_ * 4 * kPi * kPi * derivative_.moment(2) / (4 * ghs_.slope_ * ghs_.slope_);
  }
  double of_radius(double radius, double dz) {
    return -change(dz).encircled_energy(radius) / ghs_.at_plane(dz).encircled_energy_slope(radius);
  }
  // The position of the highest irradiance stays fixed: its shift has no first-order effect.
  double of_strehl(double value) {
    if (ghs_.pupil().has_uneven_light()) return of_uneven_strehl();
    const MeanSpot focus = ghs_.at_plane(0);
    const double radius = ghs_.departs() ? focus.highest_radius() : 0;
    return value * change(0).irradiance(radius) / focus.irradiance(radius);
  }
  double of_uneven_strehl() const {
    const AberratedLight light(ghs_.pupil());
    return central_difference([&](const RadialPsd& psd) { return light.peak(psd).strehl; });
  }
  double of_transfer(double frequency) {
    const double sign = ghs_.at_plane(0).transfer(frequency) < 0 ? -1 : 1;
    return sign * change(0).transfer(frequency);
  }
  double of_spot(double bandwidth, double width) {
    const double nu = ghs_.highest_frequency(), w = width * kPi * nu;
    const RadialTransform moved = ghs_.line_spread(bandwidth, &surface());
    const double slope = ghs_.line_spread(bandwidth, nullptr).cosine_slope(w);
    return -(moved.cosine(w) - 0.5 * moved.cosine(0)) / (slope * kPi * nu);
  }
  // N(z) = E(R, z) falls to half of its peak, whose shift has no first-order effect. R may move, too.
  double of_ring(const RingFwhm& ring) {
    const double radius = radius_of(ring, ghs_);
    const double widened = ring.ring_radius ? 0 : of_radius(radius, 0);
    const auto in_ring = [&](double dz) {
      return change(dz).encircled_energy(radius) + widened * ghs_.at_plane(dz).encircled_energy_slope(radius);
    };
    const GeneralisedHarveyShack::RingPlanes planes = ghs_.ring_planes(radius);
    const double half = 0.5 * in_ring(planes.peak);
    const auto moved = [&](double plane) {
      const double step = kPlaneStep * std::abs(plane - planes.peak);
      const auto difference = [&](int k) {
        return ghs_.make_plane(plane + k * step).encircled_energy(radius) -
               ghs_.make_plane(plane - k * step).encircled_energy(radius);
      };
      const double slope = (4.0 / 5 * difference(1) - 1.0 / 5 * difference(2) + 4.0 / 105 * difference(3) -
                            1.0 / 280 * difference(4)) /
                           step;
      return (in_ring(plane) - half) / slope;
    };
    return moved(planes.lower) - moved(planes.upper);
  }

  // The FWHM w solves I(w/2) = I(peak)/2. At the peak the irradiance does not change with the radius.
  double of_fwhm(double dz, double width) {
    const MeanSpot spot = ghs_.at_plane(dz);
    const double r = 0.5 * width;
    const MeanSpot& moved = change(dz);
    return -2 * (moved.irradiance(r) - 0.5 * moved.irradiance(spot.peak_radius())) / spot.irradiance_slope(r);
  }
  double of_patch(const PatchBsdf& patch) const {
    return central_difference(
        [&](const RadialPsd& psd) { return ScatterFunction(psd, ghs_.wavelength_).bsdf(patch.theta); });
  }
  // d value(psd)/d ln p.
  template <typename Value>
  double central_difference(const Value& value) const {
    const auto at = [&](double log) {
      return value(RadialPsd(with_value(model_, parameter_, scale_ * std::exp(log))));
    };
    return (at(kPatchStep) - at(-kPatchStep)) / (2 * kPatchStep);
  }

  const GeneralisedHarveyShack& ghs_;
  const PsdModel& model_;
  const PsdVariable& parameter_;
  PsdDerivative derivative_;
  double scale_;
  GeneralisedHarveyShack::SurfaceChange surface_;
  std::map<double, MeanSpot> planes_;
};

Eigen::MatrixXd PsdJacobian::logarithmic() const {
  return values.cwiseInverse().asDiagonal() * derivatives * parameter_values.asDiagonal();
}

PsdJacobian psd_jacobian(const PsdModel& psd, const std::vector<PsdVariable>& parameters,
                         const std::vector<Statistic>& statistics, const GhsPupil& pupil, int threads,
                         const LightProperties* light) {
  PsdJacobian result;
  result.parameters = parameters;
  const GeneralisedHarveyShack ghs(RadialPsd(psd), pupil);
  result.values = ghs.predict(statistics, threads);
  const auto own = Eigen::Index(statistics.size()), columns = Eigen::Index(parameters.size());
  const Eigen::Index rows = own + (light ? Eigen::Index(light->wanted().size()) : 0);
  if (light) {
    result.values.conservativeResize(rows);
    result.values.tail(rows - own) = (*light)(ghs);
  }
  result.parameter_values.resize(columns);
  result.derivatives.resize(rows, columns);
  for (Eigen::Index k = 0; k < columns; ++k)
    result.parameter_values[k] = value_of(psd, parameters[std::size_t(k)]);
  parallel_for(parameters.size(), threads, [&](std::size_t k) {
    const auto column = Eigen::Index(k);
    JacobianOfGhs jacobian(ghs, psd, parameters[k]);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double change = i < own ? jacobian(statistics[std::size_t(i)], result.values[i])
                                    : jacobian.of_light(*light, std::size_t(i - own), result.values[i]);
      result.derivatives(i, column) = change / result.parameter_values[column];
    }
  });
  return result;
}

}  // namespace aberfit
