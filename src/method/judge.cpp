#include "aberfit/method/judge.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "aberfit/core/errors.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"

namespace aberfit {
namespace {

// Targets and margins by GHS, in place of those of the fitted theory.
std::vector<Target> targets_of_light(const GeneralisedHarveyShack& light, std::vector<Target> targets,
                                     int threads) {
  Eigen::VectorXd slopes;
  const Eigen::VectorXd predicted = light.predict(statistics_of(targets), threads, &slopes);
  for (std::size_t k = 0; k < targets.size(); ++k) {
    targets[k].value = predicted[Eigen::Index(k)];
    targets[k].standard_error = 0;
    targets[k].degrees_of_freedom = std::numeric_limits<double>::infinity();
    if (targets[k].curve_slope) targets[k].curve_slope = slopes[Eigen::Index(k)];
  }
  std::erase_if(targets, [](const Target& target) { return !std::isfinite(target.value); });
  return targets;
}

std::vector<Target> seen_by_waves(std::vector<Target> targets) {
  std::erase_if(targets, [](const Target& target) { return !kind_of(target.statistic).in_waves(); });
  return targets;
}

}  // namespace

LightJudgement judge_in_light(const FitCase& of, const TermSet& terms, const Eigen::VectorXd& coefficients,
                              Warnings* warnings, double least_reach) {
  const Task& task = of.task;
  const Groundwork& ground = of.ground;
  const bool given = of.targets.theory == "given";
  LightJudgement light;
  light.decides = ground.use.light_decides;
  light.theory = given ? "given" : to_string(Theory::kGhs);
  light.obstacle = ground.use.obstacle;
  if (!light.obstacle.empty()) return light;
  std::vector<Target> fitted = seen_by_waves(of.targets.fitted), held_out;
  if (light.decides) held_out = seen_by_waves(of.targets.held_out);
  if (!given && ground.use.theory != Theory::kGhs) {
    std::shared_ptr<const GeneralisedHarveyShack> spot = ground.specified_spot;
    if (!spot)
      spot = std::make_shared<const GeneralisedHarveyShack>(ground.psd->scaled(ground.prior_height_factor),
                                                            task.mirror, task.aperture, task.wavelength);
    fitted = targets_of_light(*spot, std::move(fitted), of.context.threads);
    held_out = targets_of_light(*spot, std::move(held_out), of.context.threads);
  }
  const JudgedSet judged(fitted, held_out);
  try {
    const double pitch = wave_pitch(task, terms, judged.targets(), ground.split.get(), 1, least_reach);
    const double cells = 2 * ground.radius / pitch;
    if (cells > law::kMostCells) {
      light.no_grid = true;
      light.obstacle =
          fmt::format("the pupil would need {:.0f} grid points across, more than {}", cells, law::kMostCells);
      return light;
    }
    const FreshPupil pupil{FocusModel::kWaves, rays_of(task.trace.pupil), task.trace.pupil.seed, pitch};
    const FreshStatistics fresh =
        statistics_with_error(lit_mirror(task, ground.split), pupil, terms, coefficients, judged.statistics(),
                              of.context.threads, warnings);
    light.metrics = judged.judge(fresh, task.equivalence);
  } catch (const ComputationError& error) {
    light.no_grid = true;
    light.obstacle = error.what();
    return light;
  }
  light.verdict = overall(light.metrics);
  return light;
}

std::optional<PerfectMirror> judge_perfect_mirror(const FitCase& of) {
  const Groundwork& ground = of.ground;
  if (!ground.psd || !ground.use.obstacle.empty()) return std::nullopt;
  std::vector<Target> seen = JudgedSet(of.targets.fitted, of.targets.held_out).targets();
  std::erase_if(seen, [](const Target& target) {
    return !std::holds_alternative<EncircledEnergyRadius>(target.statistic) &&
           kind_of(target.statistic).dimension != Dimension::kFraction;
  });
  if (seen.empty()) return std::nullopt;
  const auto beside = std::stable_partition(seen.begin(), seen.end(), [](const Target& target) {
    return plane_of_light(target.statistic).value_or(0) == 0;
  });
  const std::vector<Target> in_focus(seen.begin(), beside), elsewhere(beside, seen.end());
  const double smooth = law::kSmoothG / std::max(law::kSmoothG, ground.numbers.g);
  const GeneralisedHarveyShack perfect(ground.psd->scaled(smooth), of.task.mirror, of.task.aperture,
                                       of.task.wavelength);
  PerfectMirror result;
  for (const std::vector<Target>* some : {&in_focus, &elsewhere}) {
    if (result.mismatch >= 1) break;
    const std::vector<Target> aims = aims_of(*some);
    const Eigen::VectorXd value = perfect.predict(statistics_of(aims), of.context.threads);
    for (std::size_t k = 0; k < aims.size(); ++k) {
      const double mismatch = std::abs(value[Eigen::Index(k)] - aims[k].value) /
                              (margin_of((*some)[k], of.task.equivalence) * aims[k].relative_to());
      if (mismatch > result.mismatch) result = {mismatch, statistic_name((*some)[k].statistic)};
    }
  }
  return result;
}

}  // namespace aberfit
