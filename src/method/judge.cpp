#include "aberfit/method/judge.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/method/pupil_choice.h"

namespace aberfit {
namespace {

constexpr int kRealisationDraws = 32;  // a spread known to 13 %

std::string why(const Groundwork& ground) {
  const double error = ground.use.choice->errors.ray_ee90;
  return fmt::format(
      "rays are not valid here: kappa = {:.3g}, and {}", ground.numbers.kappa,
      std::isfinite(error)
          ? fmt::format("the ray ee90 is {:+.3g} % off the Harvey-Shack prediction", 100 * error)
          : "the Harvey-Shack prediction has no finite ee90");
}

}  // namespace

std::optional<NeededJudgement> judge_by_need(const Task& task, const Groundwork& ground,
                                             const TargetSets& targets, const TermSet& terms,
                                             const Eigen::VectorXd& coefficients, int threads,
                                             Warnings* warnings) {
  const bool given = targets.theory == "given";
  if (!ground.use.too_simple(given)) return std::nullopt;
  const FocusModel model = ground.use.choice->model;
  NeededJudgement judgement;
  judgement.theory = given ? "given" : to_string(theory_of(model));
  judgement.model = to_string(model);
  judgement.reason = why(ground);
  if (!ground.use.obstacle.empty()) {
    judgement.reason += ", but what is needed cannot be computed: " + ground.use.obstacle + ".";
    return judgement;
  }
  judgement.reason += ".";
  std::vector<Target> wanted;
  std::vector<Statistic> statistics;
  for (const Target& target : targets.fitted) {
    if (std::holds_alternative<RmsRadius>(target.statistic)) continue;
    wanted.push_back(target);
    statistics.push_back(target.statistic);
  }
  if (!given) {
    const GeneralisedHarveyShack spot(*ground.prior_psd, task.mirror, task.aperture, task.wavelength);
    const Eigen::VectorXd predicted = spot.predict(statistics, threads);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      wanted[k].value = predicted[Eigen::Index(k)];
      wanted[k].standard_error = 0;
      wanted[k].degrees_of_freedom = std::numeric_limits<double>::infinity();
    }
  }
  const FreshPupil pupil{model, task.trace.pupil.rays, task.trace.pupil.seed,
                         wave_pitch(task, terms, wanted)};
  const FreshStatistics fresh =
      statistics_with_error(lit_mirror(task), pupil, terms, coefficients, statistics, threads, warnings);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const auto at = Eigen::Index(k);
    judgement.metrics.push_back(tost(statistic_name(statistics[k]), false, wanted[k].value,
                                     wanted[k].standard_error, fresh.value[at], fresh.standard_error[at],
                                     task.equivalence.margin, task.equivalence.confidence,
                                     {wanted[k].degrees_of_freedom, fresh.degrees_of_freedom}));
  }
  judgement.verdict = overall(judgement.metrics);
  return judgement;
}

Realisation realisation_of(const Task& task, const Groundwork& ground, const LightPath& focus,
                           const CoefficientPrior& prior, int threads) {
  Realisation realisation{ground.numbers.realisation_spread, std::nan(""), 0};
  const double share = realisation.predicted / task.equivalence.margin;
  if (!(share >= 0.5) || (share > 2 && focus.model == FocusModel::kRays)) return realisation;
  realisation.measured = measured_spread(focus, prior, task.fit.seed, kRealisationDraws, threads);
  if (std::isfinite(realisation.measured)) realisation.draws = kRealisationDraws;
  return realisation;
}

void describe_models(const Groundwork& ground, const std::string& theory, FitOutcome* result) {
  result->theory = theory;
  result->model = to_string(ground.use.model);
  result->model_reason = ground.use.reason;
  if (!ground.use.choice) return;
  result->needed = to_string(ground.use.choice->model);
  result->errors = ground.use.choice->errors;
}

void warn_of_surface_regime(const Groundwork& ground, const SceneNumbers& surface, Warnings* warnings) {
  const FocusModel specified = regime(ground.numbers), own = regime(surface);
  if (own == specified) return;
  warnings->push_back(
      {"surface-regime",
       fmt::format("by its own height the fitted surface (RMS {:.4g} nm, kappa {:.2f}) calls for {}, while "
                   "the specification (RMS {:.4g} nm, kappa {:.2f}) calls for {}",
                   1e9 * surface.rms_height, surface.kappa, to_string(own), 1e9 * ground.numbers.rms_height,
                   ground.numbers.kappa, to_string(specified))});
}

}  // namespace aberfit
