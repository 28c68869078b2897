#include "aberfit/theory/generalised_harvey_shack.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/root.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/scene/segments.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/scattering_band.h"
#include "exact_transfer.h"
#include "radial_transform.h"
#include "ring_planes.h"
#include "surface_transfer.h"

namespace aberfit {
using namespace internal;

namespace {

using std::numbers::pi;

constexpr std::size_t kMostPlanes = 100;
constexpr double kSameFrequency = 1e-12;  // relative; edges of panels of two wavelengths

}  // namespace

struct GeneralisedHarveyShack::Planes {
  std::mutex mutex;
  std::map<double, MeanSpot> spots;
};

GhsPupil::GhsPupil(const Mirror& mirror, const Aperture& aperture, const Light& light,
                   const GhsOptions& options)
    : mirror_(mirror), aperture_(aperture), light_(light), wavelength_(light), options_(options) {
  moments_ = std::make_shared<const PupilMoments>(
      PupilField(mirror, aperture, wavelength_, options.departure), options.halvings);
  if (!light.is_band()) return;
  for (const LightLine& line : light.lines()) lines_.emplace_back(mirror, aperture, line.wavelength, options);
}

GhsPupil GhsPupil::of_parabola() const {
  if (is_parabola(mirror_) && !options_.departure) return with_segments_in_place();
  GhsOptions options = options_;
  options.departure = {};
  return {Mirror{mirror_.focal_length}, without_segment_errors(aperture_), light_, options};
}

GhsPupil GhsPupil::with_segments_in_place() const {
  if (!has_segment_errors(aperture_)) return *this;
  return {mirror_, without_segment_errors(aperture_), light_, options_};
}

bool GhsPupil::has_uneven_light() const { return moments_->has_departure() && !moments_->is_round(); }

GeneralisedHarveyShack::GeneralisedHarveyShack(const RadialPsd& psd, const Mirror& mirror,
                                               const Aperture& aperture, const Light& light,
                                               const GhsOptions& options)
    : GeneralisedHarveyShack(psd, GhsPupil(mirror, aperture, light, options)) {}

GeneralisedHarveyShack::GeneralisedHarveyShack(const RadialPsd& psd, const GhsPupil& pupil)
    : pupil_(pupil),
      whole_(psd),
      psd_(psd),
      mirror_(pupil.mirror_),
      aperture_(pupil.aperture_),
      wavelength_(pupil.wavelength_),
      planes_(std::make_unique<Planes>()) {
  const PsdMoments moments = psd_moments(psd);
  rms_height_ = moments.rms_height();
  slope_ = moments.rms_slope_per_axis();
  const ScatteringBand band = scattering_band(psd, wavelength_);
  psd_ = band.psd;
  cut_share_ = band.cut_share;
  g_ = 4 * pi * band.rms_height / wavelength_;
  if (!std::isfinite(structure_function(psd_, Eigen::ArrayXd::Constant(1, aperture_radius(aperture_)))[0]))
    throw ComputationError(
        "the structure function of this PSD is infinite, so there is no generalised Harvey-Shack prediction; "
        "give the PSD a lowest frequency");
  exact_ = std::make_unique<const ExactTransfer>(
      pupil.moments_, [this](const Eigen::ArrayXd& x) { return exponent(x); }, g_ * g_,
      of_uneven_paths([this](double power, double a, double b) { return radial_moment(psd_, power, a, b); }),
      transfer_options(psd_, wavelength_, pupil.moments_->cutoff(), pupil.options_.halvings));
  for (const GhsPupil& line : pupil.lines_)
    lines_.push_back(std::make_shared<const GeneralisedHarveyShack>(psd, line));
  core_ = is_band() ? mean_of_lines([](const GeneralisedHarveyShack& line) { return line.core_; })
                    : exact_->core_share();
}

double GeneralisedHarveyShack::mean_of_lines(
    const std::function<double(const GeneralisedHarveyShack& line)>& of) const {
  double sum = 0;
  for (std::size_t k = 0; k < lines_.size(); ++k) sum += share(k) * of(*lines_[k]);
  return sum;
}

double GeneralisedHarveyShack::share(std::size_t line) const { return pupil_.light_.lines()[line].share; }

double GeneralisedHarveyShack::cutoff() const { return exact_->cutoff(); }

double GeneralisedHarveyShack::highest_frequency() const {
  return cutoff() / (pupil_.light_.shortest() * mirror_.focal_length);
}

GeneralisedHarveyShack::~GeneralisedHarveyShack() = default;
GeneralisedHarveyShack::GeneralisedHarveyShack(GeneralisedHarveyShack&&) noexcept = default;
GeneralisedHarveyShack& GeneralisedHarveyShack::operator=(GeneralisedHarveyShack&&) noexcept = default;

Eigen::ArrayXd GeneralisedHarveyShack::exponent(const Eigen::ArrayXd& x) const {
  return surface_exponent(psd_, wavelength_, x);
}

MeanSpot GeneralisedHarveyShack::at_plane(double dz) const {
  if (!(std::isfinite(dz) && mirror_.focal_length + dz > 0))
    throw ComputationError("the plane of the spot lies behind the mirror");
  {
    const std::lock_guard lock(planes_->mutex);
    if (const auto known = planes_->spots.find(dz); known != planes_->spots.end()) return known->second;
  }
  MeanSpot spot = make_plane(dz);
  const std::lock_guard lock(planes_->mutex);
  if (planes_->spots.size() < kMostPlanes) planes_->spots.emplace(dz, spot);
  return spot;
}

MeanSpot GeneralisedHarveyShack::empty_plane(double dz) const {
  MeanSpot spot;
  const double f = mirror_.focal_length, radius = aperture_radius(aperture_);
  spot.focal_length_ = f;
  const double shortest = pupil_.light_.shortest();
  spot.cutoff_ = cutoff() * wavelength_ / shortest;  // scaled from the mean wavelength
  spot.v_per_radius_ = 2 * pi * cutoff() / (shortest * (f + dz));
  spot.guess_ =
      std::hypot(wavelength_ * f / radius, dz * radius / f, std::isfinite(slope_) ? 2 * f * slope_ : 0.0);
  return spot;
}

MeanSpot GeneralisedHarveyShack::sum_of_lines(
    double dz, const std::function<MeanSpot(std::size_t line)>& spot_of) const {
  struct Part {
    MeanSpot spot;
    double stretch, share;  // stretch: from s of this wavelength to s of the shortest one
  };
  std::vector<Part> parts;
  std::vector<double> edges;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double stretch = pupil_.light_.shortest() / lines_[k]->wavelength_;
    parts.push_back({spot_of(k), stretch, share(k)});
    for (const TransferPanel& panel : parts.back().spot.transform_->panels())
      edges.insert(edges.end(), {stretch * panel.a, stretch * panel.b});
  }
  std::sort(edges.begin(), edges.end());
  std::vector<TransferPanel> panels;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    TransferPanel panel{edges[k], edges[k + 1]};
    if (!(panel.b - panel.a > kSameFrequency * panel.b)) continue;
    for (const Part& part : parts)
      panel.value += part.share * part.spot.transform_->on(panel.a / part.stretch, panel.b / part.stretch);
    if (panel.value.abs().maxCoeff() > 0) panels.push_back(panel);
  }
  MeanSpot sum = empty_plane(dz);
  sum.transform_ = std::make_shared<const RadialTransform>(std::move(panels));
  return sum;
}

MeanSpot GeneralisedHarveyShack::make_plane(double dz) const {
  if (is_band()) return sum_of_lines(dz, [&](std::size_t line) { return lines_[line]->at_plane(dz); });
  MeanSpot spot = empty_plane(dz);
  spot.transform_ = std::make_shared<const RadialTransform>(exact_->panels(dz, false));
  return spot;
}

PsdDerivative GeneralisedHarveyShack::scattering(const PsdDerivative& derivative) const {
  return psd_.f_max() < whole_.f_max() ? derivative.band(0, 1 / wavelength_) : derivative;
}

double GeneralisedHarveyShack::limit_change(const PsdDerivative& derivative, double scale) const {
  if (!std::isfinite(g_)) return 0;  // no limit and no core
  return scale * std::pow(4 * pi / wavelength_, 2) * scattering(derivative).moment(0);
}

// (4 pi/lambda)^2 V of PHYSICS 6, linear in S. Waves longer than ten apertures tilt the mirror and lift it; a
// lift moves no energy. A tilt s has the phase (4 pi/lambda) q s r, and q r is the position in the pupil. So
// pairs have (4 pi/lambda)^2 (s x)^2/2 in all. That is q1 q2 (C(0) - C(dr)) less (q1 - q2)^2 f^2 s^2 along
// the shear.
double GeneralisedHarveyShack::of_uneven_paths(
    const std::function<double(double power, double a, double b)>& moment) const {
  constexpr double kApertures = 10;
  const double end = 1 / (kApertures * 2 * aperture_radius(aperture_)), f = mirror_.focal_length;
  return std::pow(4 * pi / wavelength_, 2) *
         (moment(0, end, kInfinity) - 2 * f * f * 4 * pi * pi * moment(2, 0, end));
}

double GeneralisedHarveyShack::core_change(const PsdDerivative& derivative, double scale) const {
  if (is_band())
    return mean_of_lines(
        [&](const GeneralisedHarveyShack& line) { return line.core_change(derivative, scale); });
  return -limit_change(derivative, scale) * exact_->core_slope();
}

GeneralisedHarveyShack::SurfaceChange GeneralisedHarveyShack::change_of(const PsdDerivative& derivative,
                                                                        double scale) const {
  SurfaceChange change;
  for (const auto& line : lines_) change.push_back(line->change_of_line(derivative, scale));
  if (!is_band()) change.push_back(change_of_line(derivative, scale));
  return change;
}

ExponentChange GeneralisedHarveyShack::change_of_line(const PsdDerivative& derivative, double scale) const {
  const PsdDerivative inside = scattering(derivative);
  if (const double proportion = inside.proportion(); proportion != 0)
    return exact_->change_of(scale * proportion);
  const double uneven =
      of_uneven_paths([&](double power, double a, double b) { return scale * inside.moment(power, a, b); });
  return exact_->change_of(
      [&](const Eigen::ArrayXd& x) -> Eigen::ArrayXd {
        return scale * exponent_change(psd_, inside, wavelength_, x);
      },
      uneven);
}

MeanSpot GeneralisedHarveyShack::change_at_plane(const SurfaceChange& change, double dz) const {
  if (is_band())
    return sum_of_lines(dz,
                        [&](std::size_t line) { return lines_[line]->change_at_plane({change[line]}, dz); });
  MeanSpot spot = empty_plane(dz);
  spot.transform_ = std::make_shared<const RadialTransform>(exact_->change_panels(dz, change.front()));
  return spot;
}

bool GeneralisedHarveyShack::departs() const { return exact_->has_departure(); }

GeneralisedHarveyShack::RingPlanes GeneralisedHarveyShack::ring_planes(double ring_radius) const {
  if (!(ring_radius > 0)) return {kNaN, kNaN, kNaN};
  const double f = mirror_.focal_length;
  // A cone of rays fills twice the area of the ring at 1.41 of this depth; diffraction adds to it.
  const double step = 0.5 * f / aperture_radius(aperture_) * ring_radius;
  // Planes are accurate to 1e-6 without symmetry, to 2e-5 with aberrations, and may take seconds.
  const bool round = exact_->is_round();
  const double accuracy = departs() ? 1e-5 : round ? 1e-9 : 1e-6;
  const double gain = !departs() && round ? 1e-11 : accuracy;  // derivatives need the peak's position
  return ring_halves([&](double dz) { return encircled_energy(ring_radius, dz); },
                     {step, 0.5 * f, accuracy, gain});
}

double GeneralisedHarveyShack::ring_fwhm(double ring_radius) const {
  const RingPlanes planes = ring_planes(ring_radius);
  return planes.upper - planes.lower;
}

RadialTransform GeneralisedHarveyShack::line_spread(double bandwidth, const SurfaceChange* change) const {
  const double nu = highest_frequency();
  const auto gaussian = [&](double s) { return std::exp(-2 * std::pow(pi * nu * bandwidth * s, 2)); };
  std::vector<TransferPanel> panels;
  const MeanSpot focus = change ? change_at_plane(*change, 0) : at_plane(0);
  for (const TransferPanel& panel : focus.transform_->panels()) append_product(panel, gaussian, &panels);
  return RadialTransform(std::move(panels));
}

double GeneralisedHarveyShack::spot_fwhm(double bandwidth) const {
  const double nu = highest_frequency();
  const RadialTransform transform = line_spread(bandwidth, nullptr);
  const double top = transform.cosine(0);
  const auto excess = [&](double w) { return transform.cosine(w) - 0.5 * top; };
  const double step = 0.2 / top;  // a profile of equivalent width pi / top
  return first_crossing(excess, 0, 0.5 * top, step, 1e5 * step, 0x1p-44) / (pi * nu);
}

double GeneralisedHarveyShack::scatter_rms() const {
  if (!std::isfinite(slope_))
    throw ComputationError("the slope variance of this PSD is infinite, so no RMS scatter angle exists");
  return GeometricHarveyShack(mirror_, aperture_, slope_, Convention::kPhysical, rms_height_).scatter_rms();
}

double GeneralisedHarveyShack::scatter_mean() const {
  if (!std::isfinite(slope_))
    throw ComputationError(
        "the slope variance of this PSD is infinite, so no geometric scatter angle exists");
  return GeometricHarveyShack(mirror_, aperture_, slope_, Convention::kPhysical, rms_height_).scatter_mean();
}

double GeneralisedHarveyShack::tis() const { return 1 - core_; }

double GeneralisedHarveyShack::surface_transfer(double x) const { return exact_->mean_surface_transfer(x); }

Eigen::ArrayXd GeneralisedHarveyShack::overlap_transfer(const Eigen::ArrayXd& x) const {
  return exact_->mean_over_overlap(x);
}

double GeneralisedHarveyShack::transfer(double x, double dz) const {
  if (!is_band()) return exact_->at(x, dz);
  return mean_of_lines([&](const GeneralisedHarveyShack& line) {
    return line.transfer(x * line.wavelength_ / wavelength_, dz);
  });
}

double GeneralisedHarveyShack::unresolved() const {
  double most = exact_->unresolved();
  for (const auto& line : lines_) most = std::max(most, line->unresolved());
  return most;
}

Eigen::VectorXd GeneralisedHarveyShack::predict(const std::vector<Statistic>& statistics, int threads,
                                                Eigen::VectorXd* curve_slope) const {
  std::map<double, std::vector<std::size_t>> planes;
  std::vector<std::vector<std::size_t>> tasks;
  for (std::size_t i = 0; i < statistics.size(); ++i)
    if (const auto dz = plane_of_light(statistics[i]))
      planes[std::isnan(*dz) ? kInfinity : *dz].push_back(i);  // a map cannot hold NaN; both throw
    else
      tasks.push_back({i});
  for (auto& [dz, members] : planes) tasks.push_back(std::move(members));
  Eigen::VectorXd result(Eigen::Index(statistics.size()));
  if (curve_slope) curve_slope->setConstant(result.size(), kNaN);
  parallel_for(tasks.size(), threads, [&](std::size_t t) {
    for (const std::size_t i : tasks[t]) {
      const double value = result[Eigen::Index(i)] = (*this)(statistics[i]);
      const auto* radius = std::get_if<EncircledEnergyRadius>(&statistics[i]);
      if (curve_slope && radius)
        (*curve_slope)[Eigen::Index(i)] = value * at_plane(radius->dz).encircled_energy_slope(value);
    }
  });
  return result;
}

}  // namespace aberfit
