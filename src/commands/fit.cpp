#include <fmt/format.h>

#include <cmath>

#include "aberfit/commands/run.h"
#include "aberfit/core/parallel.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/fewest_terms.h"
#include "aberfit/method/fresh_statistics.h"
#include "aberfit/method/scene.h"
#include "aberfit/method/term_search.h"
#include "aberfit/report/plots.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/ray_perturbation.h"
#include "analytic_normals.h"
#include "output_directory.h"
#include "outputs.h"
#include "terminal.h"

namespace aberfit {
namespace {

EquivalentSurface describe_surface(const Study& study, const Scene& scene, const Workbench& bench,
                                   const TermSet& terms, const CoefficientPrior& prior, const FitResult& fit,
                                   int threads, Warnings* warnings) {
  EquivalentSurface surface;
  surface.prior_height_factor = scene.prior_height_factor;
  const SurfaceField field = bench.field(fit.coefficients);
  const Eigen::ArrayXd& weight = bench.pupil.weight;
  const double mean = (weight * field.height).sum();
  surface.rms_height = std::sqrt((weight * (field.height - mean).square()).sum());
  surface.rms_slope_per_axis =
      std::sqrt((weight * (field.slope_x.square() + field.slope_y.square())).sum() / 2);
  surface.g = 4 * EIGEN_PI * surface.rms_height / study.wavelength;
  surface.kappa = std::nan("");  // unknown without a spectrum
  if (scene.psd) {
    // Same shape of spectrum, the fitted surface's own height.
    const double factor = surface.rms_height / scene.numbers.rms_height;
    const SceneNumbers own =
        scene_numbers(scene.psd->scaled(factor), study.mirror, study.aperture, study.wavelength);
    surface.kappa = own.kappa;
    surface.needed = to_string(physics_of(regime(own)));
    warn_of_surface_regime(scene, own, warnings);
  }
  if ((!terms.zernike.empty() || !terms.fourier.empty()) && surface.rms_slope_per_axis > 0)
    surface.zones = zone_slopes(study, terms, prior, fit.coefficients, threads);
  return surface;
}

// The verdict is on the model that the scene needs. Where that cannot be computed, a good result on a simpler
// model decides nothing.
void decide_by_need(const Study& study, const Scene& scene, const TargetSets& targets, int threads,
                    ResultDocument* result) {
  result->needed_judgement = judge_by_need(study, scene, targets, result->terms, result->fit.coefficients,
                                           threads, &result->warnings);
  if (!result->needed_judgement) return;
  const NeededJudgement& needed = *result->needed_judgement;
  const bool cannot = needed.metrics.empty() && result->verdict == Verdict::kDifferent;
  if (!cannot) result->verdict = needed.verdict;
}

std::string spread_source(const Scene& scene, const Realisation& realisation) {
  std::string text = fmt::format("0.65/sqrt(N_eff), N_eff = {:.0f}", scene.numbers.n_eff);
  if (realisation.draws > 0)
    text = fmt::format("{:.1f} % by {}, {:.1f} % over {} draws", 100 * realisation.predicted, text,
                       100 * realisation.measured, realisation.draws);
  return text;
}

void warn_of_result(const Study& study, const Scene& scene, const FreshStatistics& fresh,
                    ResultDocument* result) {
  Warnings& warnings = result->warnings;
  if (result->realisation && result->realisation->spread() > study.equivalence.margin)
    warnings.push_back(
        {"realisation-spread",
         fmt::format("draws of this roughness differ by {:.1f} % in ee90 ({}): the verdict holds for the "
                     "calibrated surface, not for any one real mirror",
                     100 * result->realisation->spread(), spread_source(scene, *result->realisation))});
  if (fresh.lost > 0)
    warnings.push_back(
        {"lost-rays", fmt::format("{} of {} fresh rays miss the focal region", fresh.lost, fresh.rays)});
  for (const ZoneSlope& zone : result->surface.zones) {
    if (zone.inside() || zone.more_even()) continue;
    warnings.push_back(
        {"zone-slope",
         fmt::format("slope RMS in the zone {:.2f}-{:.2f} R is {:.3f} of the overall one; draws "
                     "of the prior give {:.3f}-{:.3f}",
                     zone.rho_min, zone.rho_max, zone.ratio, zone.draws_low, zone.draws_high)});
  }
  if (scene.use.physics != FocusPhysics::kWaves && result->rays < 30 * result->terms.size() &&
      result->targets.size() > 10)
    warnings.push_back(
        {"few-rays", fmt::format("{} rays for {} terms: the terms can follow single rays; use more rays",
                                 result->rays, result->terms.size())});
}

}  // namespace

ResultDocument run_fit(const Study& study, const RunOptions& options) {
  require_analytic_normals(study);
  const int threads = options.threads > 0 ? options.threads : available_threads();
  const auto say = [&](const std::string& line) {
    if (options.progress) options.progress(line);
  };

  const Scene scene = make_scene(study);
  say("targets");
  const TargetSets targets = make_targets(study, scene, threads);
  const bool search = study.terms.automatic && scene.psd;  // without PSD make_terms says what is missing
  Attempt attempt = search ? fit_fewest_terms(study, scene, targets, options, threads)
                           : fit_on_enough_rays(study, scene, targets, options, {}, true, threads);
  ResultDocument& result = attempt.result;
  decide_by_need(study, scene, targets, threads, &result);
  if (scene.psd) {
    say("realisations");
    result.realisation = realisation_of(study, scene, attempt.bench->focus(study), attempt.prior, threads);
  }

  say("zones");
  result.surface = describe_surface(study, scene, *attempt.bench, result.terms, attempt.prior, result.fit,
                                    threads, &result.warnings);
  result.surface.captured_fraction = attempt.captured;
  if (scene.psd) result.band = band_use(study, scene, result.terms, result.rays);
  warn_of_result(study, scene, attempt.fresh, &result);
  result.provenance = make_provenance(study.fit.seed, threads);
  result.provenance.libraries["ceres"] = solver_version();

  if (!options.output_directory.empty())
    write_fit(study, scene, options, attempt.bench->focus(study), &result);
  return std::move(result);
}

ExitCode fit_command(CommandLine line) {
  const Study study = read_study(line.study_file);
  choose_output_directory(&line);
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const ResultDocument result = study.target.map ? run_map_fit(study, options) : run_fit(study, options);
  progress.clear();
  print(line, line.json ? to_json(result) : nlohmann::ordered_json(), summary_table(result, false));
  say_where(line);
  if (result.fit.status == FitStatus::kFailed) return ExitCode::kComputationFailed;
  const bool judged_well = result.map.has_value() || result.verdict == Verdict::kEquivalent;
  const bool met = result.fit.status == FitStatus::kConverged && judged_well;
  return met ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
