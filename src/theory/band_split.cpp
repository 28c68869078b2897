#include "aberfit/theory/band_split.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/scene/segments.h"
#include "aberfit/theory/geometric_harvey_shack.h"

namespace aberfit {
namespace {

constexpr double kReachOfLow = 0.95;

// Energy beyond the field of view has no segment errors, because the grid of a surface has them.
std::shared_ptr<const GeneralisedHarveyShack> with_segments_in_place(
    std::shared_ptr<const GeneralisedHarveyShack> whole) {
  if (!has_segment_errors(whole->pupil().aperture())) return whole;
  return std::make_shared<const GeneralisedHarveyShack>(whole->psd(),
                                                        whole->pupil().with_segments_in_place());
}

}  // namespace

BandSplit::BandSplit(const RadialPsd& psd, double cut, const Mirror& mirror, const Aperture& aperture,
                     const Light& light, std::shared_ptr<const GeneralisedHarveyShack> whole)
    : cut_(cut),
      low_(psd.band(0, cut)),
      rest_(psd.band(cut, kInfinity)),
      memory_(std::make_unique<Memory>()),
      whole_(with_segments_in_place(std::move(whole))) {
  focus_ = whole_->at_plane(0);
  for (std::size_t k = 0; k < whole_->lines().size(); ++k)
    lines_.push_back(std::make_shared<const BandSplit>(psd, cut, mirror, aperture,
                                                       light.lines()[k].wavelength, whole_->lines()[k]));
  const GhsPupil parabola = whole_->pupil().of_parabola();  // its overlap has no phase
  if (cut > psd.f_min()) {
    low_light_.emplace(low_, parabola);
    low_reach_ = std::max(low_light_->at_plane(0).encircled_energy_radius(kReachOfLow),
                          light.longest() * mirror.focal_length * low_.f_max());
  }
  if (!(cut < psd.f_max())) return;
  rest_light_.emplace(rest_, parabola);
  const PsdMoments moments = psd_moments(rest_);
  rest_height_ = moments.rms_height();
  rest_slope_ = moments.rms_slope_per_axis();
  rest_angle_ =
      GeometricHarveyShack(mirror, aperture, rest_slope_, Convention::kPhysical, rest_height_).scatter_rms();
}

std::optional<MeanScatter::Encircled> BandSplit::in_plane(double radius, double dz) const {
  constexpr std::size_t kMostKnown = 100000;
  if (!std::isfinite(radius) || !std::isfinite(dz)) return Encircled{kNaN, kNaN};
  const std::pair key(dz, radius);
  std::optional<MeanSpot> spot;
  bool looked_for = dz == 0;
  {
    const std::lock_guard lock(memory_->mutex);
    if (const auto at = memory_->known.find(key); at != memory_->known.end()) return at->second;
    const auto plane = memory_->spots.find(dz);
    looked_for = looked_for || plane != memory_->spots.end();
    spot = dz == 0 ? focus_ : looked_for ? plane->second : std::nullopt;
  }
  if (!looked_for) {
    try {
      spot = whole_->at_plane(dz);
    } catch (const ComputationError&) {  // the phase of the aberrations is too steep
    }
  }
  std::optional<Encircled> light;
  if (spot) light = Encircled{spot->encircled_energy(radius), spot->encircled_energy_slope(radius)};
  const std::lock_guard lock(memory_->mutex);
  if (!looked_for) memory_->spots.emplace(dz, spot);
  if (memory_->known.size() >= kMostKnown) memory_->known.clear();
  if (light) memory_->known.emplace(key, *light);
  return light;
}

double BandSplit::tis() const { return rest_light_ ? rest_light_->tis() : 0; }

Eigen::ArrayXd BandSplit::transfer(const Eigen::ArrayXd& shear) const {
  return rest_light_ ? rest_light_->overlap_transfer(shear)
                     : Eigen::ArrayXd(Eigen::ArrayXd::Ones(shear.size()));
}

Eigen::ArrayXd BandSplit::whole_transfer(const Eigen::ArrayXd& shear) const {
  return low_light_ ? Eigen::ArrayXd(low_light_->overlap_transfer(shear) * transfer(shear)) : transfer(shear);
}

}  // namespace aberfit
