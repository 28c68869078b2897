#include "aberfit/method/band_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/theory/realisation_spread.h"

namespace aberfit {
namespace {

bool can_split(const Groundwork& ground) {
  return ground.mean_spot && ground.use.model == FocusModel::kWaves;
}

BandRule rule_of(const Task& task) {
  if (task.terms.band.rule != BandRule::kDefault) return task.terms.band.rule;
  return task.terms.automatic && task.target.theory != Theory::kGeometric ? BandRule::kAuto : BandRule::kAll;
}

// Scatter multiplies a transfer function.
void refuse_cut(const Groundwork& ground) {
  throw FieldError("terms.band",
                   ground.mean_spot ? "a frequency, but the surface of this study is traced by rays"
                                    : "a frequency, but the targets of this study are not those of light",
                   "\"all\", \"auto\"; or trace model \"waves\" with theory \"auto\"");
}

// The light that is judged, and how far mirrors may differ in it: a share of the verdict's tolerances.
struct Judged {
  std::vector<FocalDisc> discs;
  std::vector<std::string> names;
  std::vector<double> light;
  SpreadLimits limits;

  void add(const Statistic& statistic, double radius, double dz, double limit) {
    discs.push_back({radius, dz});
    names.push_back(statistic_name(statistic));
    light.push_back(limit);
  }
};

// The ring holds N(z); its width ends where N is half of what it is in focus. To first order a change of N
// there moves the end by as much over the slope.
void add_ring(const Target& target, const GeneralisedHarveyShack& mean, double allowed, Judged* judged) {
  const auto& ring = std::get<RingFwhm>(target.statistic);
  const double radius =
      ring.ring_radius ? *ring.ring_radius : mean.encircled_energy_radius(ring.ring_fraction, 0);
  const double end = 0.5 * target.value, step = 0.02 * target.value;
  const double slope =
      std::abs(mean.encircled_energy(radius, end + step) - mean.encircled_energy(radius, end - step)) /
      (2 * step);
  if (!(slope > 0) || !std::isfinite(radius)) return;
  judged->add(target.statistic, radius, end, allowed * target.value * slope / std::sqrt(2.0));
}

Judged judged_of(const Task& task, const Groundwork& ground, const TargetSets& targets) {
  const double allowed = kSpreadShareOfMargin * task.equivalence.margin;
  Judged judged;
  for (const std::vector<Target>* set : {&targets.fitted, &targets.held_out})
    for (const Target& target : *set) {
      const Target aim = aim_of(target);
      if (const auto* share = std::get_if<RingThrough>(&aim.statistic))
        judged.add(target.statistic, share->ring_radius, share->dz, allowed * aim.relative_to());
      else if (std::holds_alternative<RingFwhm>(target.statistic))
        add_ring(target, *ground.mean_spot, allowed, &judged);
      else if (std::holds_alternative<RmsHeight>(target.statistic))
        judged.limits.rms_height = allowed;
      else if (std::holds_alternative<ScatterRms>(target.statistic))
        judged.limits.rms_slope = allowed;
    }
  judged.limits.light =
      Eigen::Map<const Eigen::ArrayXd>(judged.light.data(), Eigen::Index(judged.light.size()));
  return judged;
}

// Largest spread over its tolerance, and whose.
void describe_spread(const RealisationSpread& spread, const Judged& judged, double cut, BandShares* shares) {
  const auto look = [&](double share, const std::string& name) {
    if (!(kSpreadShareOfMargin * share > shares->spread)) return;
    shares->spread = kSpreadShareOfMargin * share;
    shares->spread_of = name;
  };
  const Eigen::ArrayXd light = spread.light(cut) / judged.limits.light;
  for (Eigen::Index k = 0; k < light.size(); ++k) look(light[k], judged.names[std::size_t(k)]);
  look(spread.rms_height(cut) / judged.limits.rms_height, "rms_height_m");
  look(spread.rms_slope(cut) / judged.limits.rms_slope, "scatter_rms_rad");
}

BandShares shares_of(const BandSplit& split, bool automatic) {
  BandShares shares;
  const PsdMoments low = psd_moments(split.low());
  shares.cut = split.has_low() ? split.cut() : 0;
  shares.automatic = automatic;
  shares.low_rms = low.rms_height();
  shares.low_slope = low.rms_slope_per_axis();
  shares.rest_rms = split.rms_height();
  shares.rest_slope = split.rms_slope_per_axis();
  shares.rest_scatter = split.scatter_rms();
  shares.tis = split.tis();
  return shares;
}

std::string reason_of(const Groundwork& ground, const BandShares& shares) {
  const auto frequency = [](double f) { return format_quantity(f, Dimension::kSpatialFrequency); };
  const std::string spread =
      fmt::format("mirrors that share {} differ by {:.2g} of a tolerance ({}, one standard deviation)",
                  shares.cut > 0 ? "the terms" : "nothing but this specification", shares.spread,
                  shares.spread_of.empty() ? "nothing is judged" : shares.spread_of);
  const std::string scatter = fmt::format(
      "{} to {} {} scatter (RMS {}, TIS {:.2g} %)", frequency(std::max(shares.cut, ground.psd->f_min())),
      frequency(ground.psd->f_max()), shares.cut > 0 ? "are" : "are all",
      format_quantity(shares.rest_rms, Dimension::kLength), 100 * shares.tis);
  if (!(shares.cut > 0)) return fmt::format("No frequency needs a term: {}; {}.", scatter, spread);
  return fmt::format("Frequencies from {} to {} ({:.3g} cycles across) are terms (RMS {}); {}; {}.",
                     frequency(ground.psd->f_min()), frequency(shares.cut), 2 * ground.radius * shares.cut,
                     format_quantity(shares.low_rms, Dimension::kLength), scatter, spread);
}

void split_at(const Task& task, double cut, bool automatic, const RealisationSpread& spread,
              const Judged& judged, Layout* layout) {
  Groundwork& ground = layout->ground;
  ground.split = std::make_shared<const BandSplit>(*ground.psd, cut, task.mirror, task.aperture,
                                                   task.wavelength, ground.mean_spot);
  ground.prior_psd = ground.term_psd = ground.split->low();
  ground.shares = shares_of(*ground.split, automatic);
  describe_spread(spread, judged, cut, &*ground.shares);
  ground.shares->reason = reason_of(ground, *ground.shares);
}

bool asks_for_mean_angle(const TargetSets& targets) {
  return std::any_of(targets.fitted.begin(), targets.fitted.end(), [](const Target& target) {
    return std::holds_alternative<ScatterMean>(target.statistic);
  });
}

void split_band(const Task& task, int threads, Layout* layout) {
  const Groundwork& ground = layout->ground;
  const BandRule rule = rule_of(task);
  if (rule == BandRule::kAll || !ground.psd) return;
  if (!can_split(ground)) {
    if (rule == BandRule::kCut) refuse_cut(ground);
    return;
  }
  if (asks_for_mean_angle(layout->targets)) {
    if (rule == BandRule::kCut)
      throw FieldError("terms.band", "a frequency, but scatter_mean is among the statistics",
                       "\"all\"; the mean angle of terms and scatter together is not known");
    return;
  }
  const Judged judged = judged_of(task, ground, layout->targets);
  const RealisationSpread spread(
      {*ground.psd, task.mirror, task.aperture, task.wavelength, *ground.mean_spot}, judged.discs, threads);
  double cut = task.terms.band.cut;
  if (rule == BandRule::kAuto) {
    const SmallestCut smallest = smallest_cut(spread, judged.limits);
    cut = smallest.whole_band ? ground.psd->f_min() : smallest.frequency;
  }
  if (cut < ground.psd->f_max())
    split_at(task, std::max(cut, ground.psd->f_min()), rule == BandRule::kAuto, spread, judged, layout);
}

}  // namespace

Layout lay_out(const Task& task, int threads) { return lay_out(task, requested_physics(task), threads); }

Layout lay_out(const Task& task, const PhysicsRequest& asked, int threads) {
  Layout layout{lay_groundwork(task, asked), {}};
  layout.targets = make_targets(task, layout.ground, threads);
  split_band(task, threads, &layout);
  return layout;
}

}  // namespace aberfit
