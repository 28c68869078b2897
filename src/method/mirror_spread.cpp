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

// Without aberrations the two sides of the focus are alike but for their scale. A disc on the other side
// serves for this one within law::kNoteworthy, because spreads are known only to a factor of 1.5.
std::size_t place_of(const FocalDisc& disc, double f, bool alike, std::vector<FocalDisc>* discs) {
  const double dz = -disc.dz / (1 + 2 * disc.dz / f), radius = disc.radius * (f + dz) / (f + disc.dz);
  const auto apart = [](double a, double b) { return std::abs(a - b) / std::abs(b); };
  double nearest = law::kNoteworthy;
  std::size_t place = discs->size();
  for (std::size_t k = 0; k < discs->size() && disc.dz != 0 && alike; ++k) {
    const FocalDisc& other = (*discs)[k];
    if (other.is_end_of_width || disc.is_end_of_width) continue;
    const double differ = std::max(apart(other.dz, dz), apart(other.radius, radius));
    if (differ < nearest) nearest = differ, place = k;
  }
  if (place == discs->size()) discs->push_back(disc);
  return place;
}

JudgedLight judged_light(const Task& task, const GeneralisedHarveyShack& mean, const TargetSets& targets) {
  JudgedLight judged;
  for (const std::vector<Target>* set : {&targets.fitted, &targets.held_out})
    for (const Target& target : *set)
      if (const auto deciding = deciding_disc(aim_of(target), mean))
        judged.members.push_back(
            {statistic_name(target.statistic), deciding->unit, margin_of(target, task.equivalence),
             place_of(deciding->disc, task.mirror.focal_length, !mean.departs(), &judged.discs)});
  return judged;
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
      if (!kind_of(target.statistic).is_moment() || !(target.relative_to() > 0)) continue;
      const double own = spread.of_moment(target.statistic, spread.lowest());
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
