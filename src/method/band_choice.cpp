#include "aberfit/method/band_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "judged_light.h"

namespace aberfit {
using namespace internal;

namespace {

void describe_spread(const LightOfMirrors& light, double cut, BandShares* shares) {
  if (light.judged.discs.empty()) return;
  const Eigen::ArrayXd differ = light.spread.light(cut);
  shares->spread = 0;
  for (const JudgedLight::Member& one : light.judged.members)
    if (const double spread = differ[Eigen::Index(one.disc)] / (one.unit * one.margin);
        !(spread <= shares->spread))
      shares->spread = spread, shares->spread_of = one.name;
  shares->height_spread = light.spread.rms_height(cut);
  shares->slope_spread = light.spread.rms_slope(cut);
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
          ? "for rays the spread of mirrors with the same terms is not known"
          : fmt::format("mirrors with the same {} differ by {:.2g} tolerances ({}, one standard deviation)",
                        shares.cut > 0 ? "terms" : "specification", shares.spread,
                        shares.spread_of.empty() ? "nothing is judged" : name_without_unit(shares.spread_of));
  const std::string scatter = fmt::format(
      "{} to {} {} scatter (RMS {}, TIS {})", frequency(std::max(shares.cut, ground.psd->f_min())),
      frequency(ground.psd->f_max()), shares.cut > 0 ? "are" : "are all",
      format_quantity(shares.rest_rms, Dimension::kLength), format_percent(shares.tis));
  if (!(shares.cut > 0)) return fmt::format("No frequency needs a term: {}; {}.", scatter, spread);
  return fmt::format("Frequencies from {} to {} ({:.3g} cycles across) are terms (RMS {}); {}; {}.",
                     frequency(ground.psd->f_min()), frequency(shares.cut), 2 * ground.radius * shares.cut,
                     format_quantity(shares.low_rms, Dimension::kLength), scatter, spread);
}

// True for a theory of rays alone. The rest of the roughness is then an independent slope of each ray.
bool only_rays(const PhysicsChoice& use) {
  return use.model == FocusModel::kRays && use.theory != Theory::kGhs;
}

void split_at(const Task& task, double cut, bool automatic, const LightOfMirrors& light, Layout* layout) {
  Groundwork& ground = layout->ground;
  ground.split = std::make_shared<const BandSplit>(*ground.psd, cut, task.mirror, task.aperture,
                                                   task.wavelength, light.mean);
  ground.prior_psd = ground.term_psd = ground.split->low();
  ground.shares = shares_of(*ground.split, automatic);
  if (only_rays(ground.use))
    ground.shares->spread = ground.shares->height_spread = ground.shares->slope_spread = kNaN;
  else
    describe_spread(light, cut, &*ground.shares);
}

BandRule rule_of(const Task& task, const BandSpec& band) {
  if (band.rule != BandRule::kDefault) return band.rule;
  return task.terms.automatic() && task.target.theory != Theory::kGeometric ? BandRule::kAuto
                                                                            : BandRule::kAll;
}

// Returns why rays cannot be split at a requested cut, a clause; empty: they can.
std::string obstacle_to_rays(const Task& task, const Groundwork& ground, double cut) {
  if (task.target.convention == Convention::kPaper)
    return "convention \"paper\" turns terms and random rays by different angles";
  if (!ground.use.obstacle.empty()) return ground.use.obstacle;
  if (cut <= ground.psd->f_min())
    return fmt::format(
        "geometric rays need terms, but all of the roughness lies above {}; without terms they are the "
        "theory itself",
        format_quantity(cut, Dimension::kSpatialFrequency));
  return "";
}

// Returns whether the roughness can be split. Throws FieldError for a requested cut that is not possible.
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

void split_band(const Task& task, const BandSpec& band, const LightOfMirrors& light, Layout* layout) {
  const Groundwork& ground = layout->ground;
  double cut = band.cut;
  if (band.rule == BandRule::kAuto) {
    const SmallestCut smallest = smallest_cut(light.spread, law::kShareOfMargin * light.judged.limits());
    cut = smallest.whole_band ? ground.psd->f_min() : smallest.frequency;
  }
  if (!(cut < ground.psd->f_max())) return;
  split_at(task, std::max(cut, ground.psd->f_min()), band.rule == BandRule::kAuto, light, layout);
  layout->ground.shares->reason = reason_of(ground, *ground.shares);
}

}  // namespace

std::string obstacle_to_split(const Groundwork& ground, const TargetSets& targets) {
  const std::vector<Target>& fitted = targets.fitted;
  if (!ground.mean_spot) return "the targets of this study are not from wave optics";
  if (ground.use.model != FocusModel::kWaves) return "the surface of this study is traced by rays";
  if (std::any_of(fitted.begin(), fitted.end(),
                  [](const Target& target) { return std::holds_alternative<ScatterMean>(target.statistic); }))
    return "scatter_mean is requested, and its value for terms and scatter together is not known";
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
  std::optional<LightOfMirrors> light;
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const BandSpec band{rule_of(task, bands[k]), bands[k].cut};
    if (!can_cut(task, band, whole)) continue;
    if (!light) light.emplace(light_of_mirrors(task, whole.ground, whole.targets, threads));
    layouts[k].ground.spread = light->of_whole_band(task, whole.targets);
    split_band(task, band, *light, &layouts[k]);
  }
  return layouts;
}

Layout lay_out_at(const Task& task, double cut, int threads) {
  Layout layout{lay_groundwork(task, {task.target.theory, FocusModel::kWaves}), {}};
  Groundwork& ground = layout.ground;
  layout.targets = make_targets(task, ground, threads);
  if (!(cut < ground.psd->f_max())) return layout;
  const LightOfMirrors light = light_of_mirrors(task, ground, layout.targets, threads);
  ground.spread = light.of_whole_band(task, layout.targets);
  split_at(task, std::max(cut, ground.psd->f_min()), false, light, &layout);
  return layout;
}

}  // namespace aberfit
