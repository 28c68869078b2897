#include "aberfit/method/band_choice.h"

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

bool can_split(const Groundwork& ground) {
  return ground.mean_spot && ground.use.model == FocusModel::kWaves;
}

BandRule rule_of(const Task& task) {
  if (task.terms.band.rule != BandRule::kDefault) return task.terms.band.rule;
  return task.terms.automatic && task.target.theory != Theory::kGeometric ? BandRule::kAuto : BandRule::kAll;
}

// Where the split is; nothing: all frequencies are the terms'.
std::optional<double> cut_of(const Task& task, const Groundwork& ground) {
  const BandRule rule = rule_of(task);
  if (rule == BandRule::kAll || !ground.psd) return std::nullopt;
  if (!can_split(ground)) {
    if (rule == BandRule::kCut)
      throw FieldError(
          "terms.band",
          "a frequency, but " + std::string(ground.mean_spot ? "the scene needs rays alone"
                                                             : "the targets are not those of light"),
          "\"all\", \"auto\"; or trace model \"waves\" with theory \"auto\"");
    return std::nullopt;
  }
  if (rule == BandRule::kCut) return task.terms.band.cut;
  return std::nullopt;
}

}  // namespace

Layout lay_out(const Task& task, int threads) { return lay_out(task, requested_physics(task), threads); }

Layout lay_out(const Task& task, const PhysicsRequest& asked, int threads) {
  Layout layout{lay_groundwork(task, asked), {}};
  Groundwork& ground = layout.ground;
  layout.targets = make_targets(task, ground, threads);
  const std::optional<double> cut = cut_of(task, ground);
  if (!cut || *cut >= ground.psd->f_max()) return layout;
  ground.split = std::make_shared<const BandSplit>(*ground.psd, *cut, task.mirror, task.aperture,
                                                   task.wavelength, ground.mean_spot);
  ground.prior_psd = ground.term_psd = ground.split->low();
  // Of a surface and a scatter function together the mean angle is no sum.
  std::erase_if(layout.targets.guides,
                [](const Target& guide) { return std::holds_alternative<ScatterMean>(guide.statistic); });
  return layout;
}

}  // namespace aberfit
