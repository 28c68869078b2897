#include "aberfit/method/band_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/theory/realisation_spread.h"

namespace aberfit {
namespace {

// The light that is judged - a mirror's own RMS height and slope are not its focus - and how far mirrors may
// differ in it: a share of the verdict's tolerances.
struct Judged {
  std::vector<FocalDisc> discs;
  std::vector<std::string> names;
  std::vector<double> limits;

  void add(const Statistic& statistic, double radius, double dz, double limit) {
    discs.push_back({radius, dz});
    names.push_back(statistic_name(statistic));
    limits.push_back(limit);
  }
  Eigen::Map<const Eigen::ArrayXd> limit() const { return {limits.data(), Eigen::Index(limits.size())}; }
};

// The ring holds N(z); its width ends where N is half of its peak. To first order a change of N there moves
// the end by as much over the slope; the flatter end counts.
void add_ring(const Target& target, const GeneralisedHarveyShack& mean, double allowed, Judged* judged) {
  const auto& ring = std::get<RingFwhm>(target.statistic);
  const double radius =
      ring.ring_radius ? *ring.ring_radius : mean.encircled_energy_radius(ring.ring_fraction, 0);
  if (!std::isfinite(radius)) return;
  const GeneralisedHarveyShack::RingPlanes planes = mean.ring_planes(radius);
  const double step = 0.02 * target.value;
  double end = planes.upper, slope = HUGE_VAL;
  for (const double plane : {planes.upper, planes.lower}) {
    const double here =
        std::abs(mean.encircled_energy(radius, plane + step) - mean.encircled_energy(radius, plane - step)) /
        (2 * step);
    if (here < slope) slope = here, end = plane;
    if (!mean.departs()) break;  // one end is as the other
  }
  if (!(slope > 0) || !std::isfinite(slope)) return;
  judged->add(target.statistic, radius, end, allowed * target.value * slope / std::sqrt(2.0));
}

// A Strehl ratio is the light in a disc so small that its edge lies within the core's top. Where aberrations
// put the highest irradiance off the axis, it is taken to differ from mirror to mirror by the same part of
// itself as the light on the axis, which is the safe side: less light differs by more of itself.
void add_strehl(const Task& task, const Target& target, const GeneralisedHarveyShack& mean, double limit,
                Judged* judged) {
  constexpr double kTop = 0.2;  // lambda f/D
  const double radius =
      kTop * task.wavelength * task.mirror.focal_length / (2 * aperture_radius(task.aperture));
  judged->add(target.statistic, radius, 0, limit * mean.encircled_energy(radius, 0) / target.value);
}

// By parts, MTF(nu) = int E(r) 2 pi nu J1(2 pi nu r) dr. What moves light moves E over radii about as one:
// the first lobe of J1, whose top lies at 1.84, counts, 1 - J0(3.83) = 1.40.
// Against 60 draws of four PSDs 1.05 to 1.99 times what is measured at 0.08 to 0.5 of the cutoff (Strehl
// ratios 0.85 to 1.04), tests/method/light_statistics_test.cpp.
void add_transfer(const Target& target, double limit, Judged* judged) {
  constexpr double kTopOfJ1 = 1.8412, kFirstLobe = 1.4028;
  const double frequency = std::get<ModulationTransfer>(target.statistic).frequency;
  judged->add(target.statistic, kTopOfJ1 / (kTwoPi * frequency), 0, limit / kFirstLobe);
}

Judged judged_of(const Task& task, const GeneralisedHarveyShack& mean, const TargetSets& targets) {
  Judged judged;
  for (const std::vector<Target>* set : {&targets.fitted, &targets.held_out})
    for (const Target& target : *set) {
      const Target aim = aim_of(target);
      const double allowed = kSpreadShareOfMargin * margin_of(target, task.equivalence);
      if (const auto* share = std::get_if<RingThrough>(&aim.statistic))
        judged.add(target.statistic, share->ring_radius, share->dz, allowed * aim.relative_to());
      else if (const auto* square = std::get_if<EnsquaredThrough>(&target.statistic))
        judged.add(target.statistic, square->side / std::sqrt(kPi), square->dz, allowed * aim.relative_to());
      else if (std::holds_alternative<RingFwhm>(target.statistic))
        add_ring(target, mean, allowed, &judged);
      else if (std::holds_alternative<StrehlRatio>(target.statistic))
        add_strehl(task, target, mean, allowed * aim.relative_to(), &judged);
      else if (std::holds_alternative<ModulationTransfer>(target.statistic))
        add_transfer(target, allowed * aim.relative_to(), &judged);
    }
  return judged;
}

// Largest spread over its tolerance, and whose.
void describe_spread(const RealisationSpread& spread, const Judged& judged, double cut, BandShares* shares) {
  Eigen::Index worst = 0;
  if (judged.discs.empty()) return;
  shares->spread = kSpreadShareOfMargin * (spread.light(cut) / judged.limit()).maxCoeff(&worst);
  shares->spread_of = judged.names[std::size_t(worst)];
  shares->height_spread = spread.rms_height(cut);
  shares->slope_spread = spread.rms_slope(cut);
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
      std::isnan(shares.spread)
          ? "by rays it is not known how far mirrors that share the terms differ"
          : fmt::format("mirrors that share {} differ by {:.2g} of a tolerance ({}, one standard deviation)",
                        shares.cut > 0 ? "the terms" : "nothing but this specification", shares.spread,
                        shares.spread_of.empty() ? "nothing is judged" : shares.spread_of);
  const std::string scatter = fmt::format(
      "{} to {} {} scatter (RMS {}, TIS {})", frequency(std::max(shares.cut, ground.psd->f_min())),
      frequency(ground.psd->f_max()), shares.cut > 0 ? "are" : "are all",
      format_quantity(shares.rest_rms, Dimension::kLength), format_percent(shares.tis));
  if (!(shares.cut > 0)) return fmt::format("No frequency needs a term: {}; {}.", scatter, spread);
  return fmt::format("Frequencies from {} to {} ({:.3g} cycles across) are terms (RMS {}); {}; {}.",
                     frequency(ground.psd->f_min()), frequency(shares.cut), 2 * ground.radius * shares.cut,
                     format_quantity(shares.low_rms, Dimension::kLength), scatter, spread);
}

// Theories of rays alone, where a study asks for one: the rest is a slope of every ray's own.
bool only_rays(const PhysicsChoice& use) {
  return use.model == FocusModel::kRays && use.theory != Theory::kGhs;
}

// The light of all mirrors, and how those that share a cut differ in what is judged of it. Theories of rays
// do without the latter.
struct SplitLight {
  std::shared_ptr<const GeneralisedHarveyShack> mean;
  Judged judged;
  std::optional<RealisationSpread> spread;
};

SplitLight light_of(const Task& task, const Layout& layout, int threads) {
  const Groundwork& ground = layout.ground;
  std::shared_ptr<const GeneralisedHarveyShack> mean = ground.specified_spot;
  if (!mean)
    mean = std::make_shared<const GeneralisedHarveyShack>(*ground.psd, task.mirror, task.aperture,
                                                          task.wavelength);
  if (only_rays(ground.use)) return {std::move(mean), {}, std::nullopt};
  Judged judged = judged_of(task, *mean, layout.targets);
  RealisationSpread spread({*ground.psd, task.mirror, task.aperture, task.wavelength, *mean}, judged.discs,
                           threads);
  return {std::move(mean), std::move(judged), std::move(spread)};
}

void split_at(const Task& task, double cut, bool automatic, const SplitLight& light, Layout* layout) {
  Groundwork& ground = layout->ground;
  ground.split = std::make_shared<const BandSplit>(*ground.psd, cut, task.mirror, task.aperture,
                                                   task.wavelength, light.mean);
  ground.prior_psd = ground.term_psd = ground.split->low();
  ground.shares = shares_of(*ground.split, automatic);
  if (light.spread)
    describe_spread(*light.spread, light.judged, cut, &*ground.shares);
  else
    ground.shares->spread = ground.shares->height_spread = ground.shares->slope_spread = kNaN;
}

BandRule rule_of(const Task& task, const BandSpec& band) {
  if (band.rule != BandRule::kDefault) return band.rule;
  return task.terms.automatic() && task.target.theory != Theory::kGeometric ? BandRule::kAuto
                                                                            : BandRule::kAll;
}

// Why rays cannot be split at a cut that was asked for, a clause; empty: they can.
std::string obstacle_to_rays(const Task& task, const Groundwork& ground, double cut) {
  if (task.target.convention == Convention::kPaper)
    return "convention \"paper\" turns terms and drawn rays by different angles";
  if (!ground.use.obstacle.empty()) return ground.use.obstacle;
  if (cut <= ground.psd->f_min())
    return fmt::format(
        "geometric rays need terms: all of the roughness lies above {}, and rays without "
        "terms are the theory itself",
        format_quantity(cut, Dimension::kSpatialFrequency));
  return "";
}

// Whether there is anything to split and a way to do it.
bool can_cut(const Task& task, const BandSpec& band, const Layout& layout) {
  const Groundwork& ground = layout.ground;
  if (band.rule == BandRule::kAll || !ground.psd) return false;
  const bool asked = band.rule == BandRule::kCut;
  const std::string obstacle = asked && only_rays(ground.use) ? obstacle_to_rays(task, ground, band.cut)
                                                              : obstacle_to_split(ground, layout.targets);
  if (!obstacle.empty() && asked)
    throw FieldError("terms.band", "a frequency, but " + obstacle,
                     "\"all\"; or theory \"auto\", trace model \"auto\" or \"waves\", convention "
                     "\"physical\", and no scatter_mean");
  return obstacle.empty();
}

void split_band(const Task& task, const BandSpec& band, const SplitLight& light, Layout* layout) {
  const Groundwork& ground = layout->ground;
  double cut = band.cut;
  if (band.rule == BandRule::kAuto) {
    const SmallestCut smallest = smallest_cut(*light.spread, light.judged.limit());
    cut = smallest.whole_band ? ground.psd->f_min() : smallest.frequency;
  }
  if (!(cut < ground.psd->f_max())) return;
  split_at(task, std::max(cut, ground.psd->f_min()), band.rule == BandRule::kAuto, light, layout);
  layout->ground.shares->reason = reason_of(ground, *ground.shares);
}

}  // namespace

std::string obstacle_to_split(const Groundwork& ground, const TargetSets& targets) {
  const std::vector<Target>& fitted = targets.fitted;
  if (!ground.mean_spot) return "the targets of this study are not those of light";
  if (ground.use.model != FocusModel::kWaves) return "the surface of this study is traced by rays";
  if (std::any_of(fitted.begin(), fitted.end(),
                  [](const Target& target) { return std::holds_alternative<ScatterMean>(target.statistic); }))
    return "scatter_mean is among the statistics, and that of terms and scatter together is not known";
  return "";
}

BandRule band_rule(const Task& task) { return rule_of(task, task.terms.band); }

Layout lay_out(const Task& task, int threads) { return lay_out(task, requested_physics(task), threads); }

Layout lay_out(const Task& task, const PhysicsRequest& asked, int threads) {
  return std::move(lay_out(task, asked, std::vector{task.terms.band}, threads).front());
}

std::vector<Layout> lay_out(const Task& task, const PhysicsRequest& asked, const std::vector<BandSpec>& bands,
                            int threads) {
  Layout whole{lay_groundwork(task, asked), {}};
  whole.targets = make_targets(task, whole.ground, threads);
  std::vector<Layout> layouts(bands.size(), whole);
  std::optional<SplitLight> light;
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const BandSpec band{rule_of(task, bands[k]), bands[k].cut};
    if (!can_cut(task, band, whole)) continue;
    if (!light) light.emplace(light_of(task, whole, threads));
    split_band(task, band, *light, &layouts[k]);
  }
  return layouts;
}

Layout lay_out_at(const Task& task, double cut, int threads) {
  Layout layout{lay_groundwork(task, {task.target.theory, FocusModel::kWaves}), {}};
  Groundwork& ground = layout.ground;
  layout.targets = make_targets(task, ground, threads);
  if (!(cut < ground.psd->f_max())) return layout;
  split_at(task, std::max(cut, ground.psd->f_min()), false, light_of(task, layout, threads), &layout);
  return layout;
}

}  // namespace aberfit
