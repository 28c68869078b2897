#include "aberfit/method/mirror_spread.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "judged_light.h"

namespace aberfit {
namespace internal {
namespace {

class Judging {
 public:
  Judging(const Task& task, const GeneralisedHarveyShack& mean) : task_(task), mean_(mean) {}

  // RMS height and slope of a mirror are no focal statistics and have no disc.
  void add(const Target& target) {
    const Target aim = aim_of(target);
    const double relative_to = aim.relative_to();
    if (const auto* share = std::get_if<RingThrough>(&aim.statistic))
      add(target, share->ring_radius, share->dz, relative_to);
    else if (const auto* energy = std::get_if<EncircledEnergyRadius>(&aim.statistic))
      add_radius(target, *energy, relative_to);
    else if (const auto* square = std::get_if<EnsquaredThrough>(&target.statistic))
      add(target, square->side / std::sqrt(kPi), square->dz, relative_to);
    else if (const auto* ring = std::get_if<RingFwhm>(&target.statistic))
      add_ring(target, *ring);
    else if (std::holds_alternative<StrehlRatio>(target.statistic))
      add_strehl(target, relative_to);
    else if (const auto* transfer = std::get_if<ModulationTransfer>(&target.statistic))
      add_transfer(target, transfer->frequency, relative_to);
  }
  JudgedLight take() { return std::move(judged_); }

 private:
  void add(const Target& target, double radius, double dz, double unit) {
    add(target, FocalDisc{radius, dz}, unit);
  }
  void add(const Target& target, const FocalDisc& disc, double unit) {
    if (!(disc.radius > 0 && std::isfinite(disc.radius) && unit > 0)) return;
    judged_.members.push_back(
        {statistic_name(target.statistic), unit, margin_of(target, task_.equivalence), place_of(disc)});
  }

  // Without aberrations the two sides of the focus are alike but for their scale. A disc on the other side
  // serves for this one within law::kNoteworthy, because spreads are known only to a factor of 1.5.
  std::size_t place_of(const FocalDisc& disc) {
    const double f = task_.mirror.focal_length, dz = -disc.dz / (1 + 2 * disc.dz / f),
                 radius = disc.radius * (f + dz) / (f + disc.dz);
    const auto apart = [](double a, double b) { return std::abs(a - b) / std::abs(b); };
    double nearest = law::kNoteworthy;
    std::size_t place = judged_.discs.size();
    for (std::size_t k = 0; k < judged_.discs.size() && disc.dz != 0 && !mean_.departs(); ++k) {
      const FocalDisc& other = judged_.discs[k];
      if (other.is_end_of_width || disc.is_end_of_width) continue;
      const double differ = std::max(apart(other.dz, dz), apart(other.radius, radius));
      if (differ < nearest) nearest = differ, place = k;
    }
    if (place == judged_.discs.size()) judged_.discs.push_back(disc);
    return place;
  }

  // A ray theory has no curve E(r). With the slope of the mean irradiance instead, the radius changes by the
  // energy in it over that slope.
  void add_radius(const Target& target, const EncircledEnergyRadius& energy, double relative_to) {
    if (!(target.value > 0)) return;
    const double slope = mean_.at_plane(energy.dz).encircled_energy_slope(target.value);
    add(target, target.value, energy.dz, relative_to * slope);
  }

  // The ring has the energy N(z); its width ends where N is half of its peak. To first order, a change of N
  // there moves the end by that change over the slope. For a mirror that departs from its parabola the
  // flatter end counts, and both ends are taken as independent.
  void add_ring(const Target& target, const RingFwhm& ring) {
    const double radius =
        ring.ring_radius ? *ring.ring_radius : mean_.encircled_energy_radius(ring.ring_fraction, 0);
    if (!std::isfinite(radius)) return;
    const GeneralisedHarveyShack::RingPlanes planes = mean_.ring_planes(radius);
    const double step = 0.02 * target.value;
    double end = planes.upper, slope = HUGE_VAL;
    for (const double plane : {planes.upper, planes.lower}) {
      const double here = std::abs(mean_.encircled_energy(radius, plane + step) -
                                   mean_.encircled_energy(radius, plane - step)) /
                          (2 * step);
      if (here < slope) slope = here, end = plane;
      if (!mean_.departs()) break;  // both ends are alike
    }
    if (!std::isfinite(slope)) return;
    const bool alike = !mean_.departs();
    add(target, FocalDisc{radius, end, alike}, target.value * slope / (alike ? 2.0 : std::sqrt(2.0)));
  }

  // A Strehl ratio is the energy in a small disc, 0.2 lambda f/D, inside the top of the core. Where
  // aberrations move the peak off the axis, its relative spread is taken from the axis. This is the safe
  // side, because a lower irradiance has a larger relative spread.
  void add_strehl(const Target& target, double relative_to) {
    const double radius =
        0.2 * task_.wavelength * task_.mirror.focal_length / (2 * aperture_radius(task_.aperture));
    add(target, radius, 0, relative_to * mean_.encircled_energy(radius, 0) / target.value);
  }

  // By parts, MTF(nu) = int E(r) 2 pi nu J1(2 pi nu r) dr. A realisation changes E at all radii nearly
  // together, so only the first lobe of J1 counts: its top at 1.84, its integral 1 - J0(3.83) = 1.40. Error:
  // 1.05 to 1.99 times the spread of 60 realisations of four PSDs, at 0.08 to 0.5 of the cutoff and Strehl
  // ratios 0.85 to 1.04 (tests/method/light_statistics_test.cpp).
  void add_transfer(const Target& target, double frequency, double relative_to) {
    add(target, 1.8412 / (kTwoPi * frequency), 0, relative_to / 1.4028);
  }

  const Task& task_;
  const GeneralisedHarveyShack& mean_;
  JudgedLight judged_;
};

JudgedLight judged_light(const Task& task, const GeneralisedHarveyShack& mean, const TargetSets& targets) {
  Judging judging(task, mean);
  for (const std::vector<Target>* set : {&targets.fitted, &targets.held_out})
    for (const Target& target : *set) judging.add(target);
  return judging.take();
}

}  // namespace

LightOfMirrors light_of_mirrors(const Task& task, const Groundwork& ground, const TargetSets& targets,
                                int threads) {
  const RadialPsd psd = ground.psd->scaled(ground.prior_height_factor);
  std::shared_ptr<const GeneralisedHarveyShack> mean = ground.specified_spot;
  if (!mean)
    mean = std::make_shared<const GeneralisedHarveyShack>(psd, task.mirror, task.aperture, task.wavelength);
  JudgedLight judged = judged_light(task, *mean, targets);
  RealisationSpread spread({psd, task.mirror, task.aperture, task.wavelength, *mean}, judged.discs, threads);
  return {std::move(mean), std::move(judged), std::move(spread)};
}

MirrorSpread LightOfMirrors::of_whole_band(const Task& task, const TargetSets& targets) const {
  MirrorSpread result;
  const Eigen::ArrayXd light = spread.light(spread.lowest());
  for (const JudgedLight::Member& one : judged.members) {
    const double relative = light[Eigen::Index(one.disc)] / one.unit;
    result.statistics.push_back({one.name, relative, relative / one.margin});
  }
  for (const std::vector<Target>* set : {&targets.fitted, &targets.held_out})
    for (const Target& target : *set) {
      if (!kind_of(target.statistic).is_moment || !(target.relative_to() > 0)) continue;
      const double own = std::holds_alternative<RmsHeight>(target.statistic)
                             ? spread.rms_height(spread.lowest())
                             : spread.rms_slope(spread.lowest());
      const double sigma = own * std::abs(target.value) / target.relative_to();
      result.statistics.push_back(
          {statistic_name(target.statistic), sigma, sigma / margin_of(target, task.equivalence)});
    }
  return result;
}

}  // namespace internal

std::string spread_words(const StatisticSpread& spread) {
  return fmt::format("{:.2g} % in {} ({:.2g} tolerances)", 100 * spread.relative,
                     name_without_unit(spread.name), spread.tolerances);
}

const StatisticSpread* MirrorSpread::worst() const {
  const auto it = std::max_element(
      statistics.begin(), statistics.end(),
      [](const StatisticSpread& a, const StatisticSpread& b) { return a.tolerances < b.tolerances; });
  return it == statistics.end() ? nullptr : &*it;
}

void MirrorSpread::tell(std::vector<EquivalenceMetric>* metrics) const {
  for (EquivalenceMetric& metric : *metrics)
    for (const StatisticSpread& one : statistics)
      if (one.name == metric.name) metric.spread = one.relative;
}

MirrorSpread mirror_spread(const Task& task, const Groundwork& ground, const TargetSets& targets,
                           int threads) {
  if (ground.spread) return *ground.spread;
  if (!ground.psd || !ground.use.obstacle.empty()) return {};
  try {
    return internal::light_of_mirrors(task, ground, targets, threads).of_whole_band(task, targets);
  } catch (const ComputationError&) {  // a plane of rays that wave optics cannot reach
    return {};
  }
}

}  // namespace aberfit
