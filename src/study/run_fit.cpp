#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/report/plots.h"
#include "aberfit/scatter/ray_perturbation.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/run.h"
#include "judge.h"
#include "outputs.h"
#include "run_map_fit.h"
#include "scene.h"
#include "spectrum_target.h"
#include "validate.h"

namespace aberfit {
namespace {

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

// The pupil that is fitted on, with the operators that live on it.
struct Workbench {
  FocusPhysics physics;
  double pitch;  // of a grid for waves [m]
  PupilSample pupil;
  SurfaceOperator surface;
  RayBundle nominal;

  Workbench(const Study& study, FocusPhysics model, double grid_pitch, const TermSet& terms, int threads)
      : physics(model),
        pitch(grid_pitch),
        pupil(focus_pupil(study, model, grid_pitch)),
        surface(terms, pupil, {threads, {}, {}}),
        nominal(trace_nominal(study.mirror, pupil)) {}

  SurfaceField field(const Eigen::VectorXd& coefficients) const {
    SurfaceField result;
    surface.apply(coefficients, &result);
    return result;
  }
  Eigen::VectorXd exact(const Study& study, const Eigen::VectorXd& coefficients,
                        const std::vector<Statistic>& statistics, int threads, Warnings* warnings) const {
    if (physics != FocusPhysics::kRays)
      return focus_statistics(focus(study), coefficients, statistics, threads, warnings);
    const SurfaceField f = field(coefficients);
    const RayBundle rays = trace(study.mirror, pupil, f);
    return evaluate_exact({rays, nominal, f.height, study.trace.centre}, statistics, threads, warnings);
  }
  FocusScene focus(const Study& study) const {
    return {study.mirror, pupil, surface, physics, study.wavelength, &study.aperture, study.trace.centre};
  }
};

// Waves need a grid as fine as the light of everything that will be asked of it.
double grid_pitch(const Study& study, const Scene& scene, const TermSet& terms, const TargetSets& targets) {
  if (scene.use.physics != FocusPhysics::kWaves) return 0;
  std::vector<Target> all = targets.fitted;
  all.insert(all.end(), targets.guides.begin(), targets.guides.end());
  all.insert(all.end(), targets.held_out.begin(), targets.held_out.end());
  return wave_pitch(study, terms, all);
}

FitOptions fit_options(const Study& study, const RunOptions& options, int threads, int tries) {
  FitOptions fit;
  fit.prior = study.fit.prior;
  fit.max_iterations = study.fit.max_iterations;
  fit.bound = study.fit.bound_sigmas;
  fit.threads = threads;
  if (options.progress) {
    fit.progress = [&options, tries](const FitProgress& p) {
      options.progress(fmt::format("fit{}: iteration {}, worst mismatch {:.3g} tolerances, {:.1f} s",
                                   tries > 0 ? fmt::format(" (start {})", tries + 1) : "", p.iteration,
                                   p.worst_mismatch, p.seconds));
      return true;
    };
  }
  return fit;
}

// Whether the solver got anywhere: a degenerate or failed try has no cost to compare.
bool has_solution(const FitResult& fit) {
  return fit.status == FitStatus::kConverged || fit.status == FitStatus::kNotConverged;
}

// Tries the seeded starts in turn and keeps the cheapest; stops at the first that meets every tolerance.
FitResult fit_from_starts(const Study& study, const FitProblem& problem, const RunOptions& options,
                          int threads, Eigen::VectorXd* start) {
  FitResult best;
  for (int k = 0; k < study.fit.starts; ++k) {
    const std::uint64_t seed =
        k == 0 ? study.fit.seed : RandomStream(study.fit.seed, "starts").bits(std::uint64_t(k));
    const Eigen::VectorXd white = study.fit.start == FitStart::kZero
                                      ? Eigen::VectorXd::Zero(problem.prior.size()).eval()
                                      : draw_white(problem.prior.size(), seed);
    const FitOptions how = fit_options(study, options, threads, k);
    FitResult result = calibrate(problem, white, how);
    const bool met = result.status == FitStatus::kConverged &&
                     within_tolerance(problem, result, std::max(1.0, how.stop_at));
    if (!has_solution(best) || (has_solution(result) && result.final_cost < best.final_cost)) {
      best = std::move(result);
      *start = white;
    }
    if (met) break;
  }
  return best;
}

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

// Two one-sided tests of every fitted and held-out statistic on rays the fit has not seen.
void judge(const Study& study, const TargetSets& targets, const FreshStatistics& fresh,
           ResultDocument* result) {
  const auto add = [&](const Target& target, bool held_out, Eigen::Index at) {
    result->metrics.push_back(tost(statistic_name(target.statistic), held_out, target.value,
                                   target.standard_error, fresh.value[at], fresh.standard_error[at],
                                   study.equivalence.margin, study.equivalence.confidence));
  };
  Eigen::Index at = 0;
  for (const Target& target : targets.fitted) add(target, false, at++);
  for (const Target& target : targets.held_out) add(target, true, at++);
  result->validated = fresh.value.head(Eigen::Index(targets.fitted.size()));
  result->verdict = overall(result->metrics);
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
    if (zone.ratio >= zone.draws_low && zone.ratio <= zone.draws_high) continue;
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
  if (study.trace.central_difference_step)
    throw InputError(study.path, "/trace/normals", "central differences in a fit",
                     "\"analytic\" normals; `verify` and `trace` take central differences");
  if (study.target.map) return run_map_fit(study, options);
  const int threads = options.threads > 0 ? options.threads : available_threads();
  const auto say = [&](const std::string& line) {
    if (options.progress) options.progress(line);
  };

  const Scene scene = make_scene(study);
  say("targets");
  const TargetSets targets = make_targets(study, scene, threads);

  ResultDocument result;
  result.study = resolved_study(study);
  result.has_roughness = scene.psd.has_value();
  result.scene = scene.numbers;
  describe_models(scene, targets.theory, &result);
  result.targets = targets.fitted;
  result.radius = scene.radius;
  double captured = 0;
  result.terms = make_terms(study, scene, &captured);
  result.warnings = scene_warnings(study, scene, result.terms, captured);

  say("prior");
  const CoefficientPrior prior = make_study_prior(study, scene, result.terms);
  const Workbench bench(study, scene.use.physics, grid_pitch(study, scene, result.terms, targets),
                        result.terms, threads);
  result.rays = bench.pupil.size();

  const SpectrumTarget spectrum = make_spectrum_target(study, scene, result.terms, prior, threads);
  FitProblem problem{study.mirror,   bench.pupil,    bench.surface,      prior,
                     targets.fitted, targets.guides, study.trace.centre, scene.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  problem.physics = bench.physics;
  problem.wavelength = study.wavelength;
  problem.aperture = &study.aperture;
  Eigen::VectorXd start;
  result.fit = fit_from_starts(study, problem, options, threads, &start);
  const std::vector<Statistic> fitted = statistics_of(targets.fitted);
  result.start = bench.exact(study, prior.colour(start), fitted, threads, nullptr);
  for (Eigen::Index b = 0; b < spectrum.value.size(); ++b)
    result.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b], result.fit.spectrum[b],
                               spectrum.tolerance[b]});
  result.fitted = bench.exact(study, result.fit.coefficients, fitted, threads, &result.warnings);

  say("fresh rays");
  std::vector<Statistic> judged = fitted;
  for (const Target& target : targets.held_out) judged.push_back(target.statistic);
  const FreshStatistics fresh =
      evaluate_fresh(study, bench.physics, bench.pitch, result.terms, result.fit.coefficients, judged,
                     4 * result.rays, threads, &result.warnings);
  judge(study, targets, fresh, &result);
  decide_by_need(study, scene, targets, threads, &result);
  if (scene.psd) {
    say("realisations");
    result.realisation = realisation_of(study, scene, bench.focus(study), prior, threads);
  }

  say("zones");
  result.surface =
      describe_surface(study, scene, bench, result.terms, prior, result.fit, threads, &result.warnings);
  result.surface.captured_fraction = captured;
  warn_of_result(study, scene, fresh, &result);
  result.provenance = make_provenance(study.fit.seed, threads);
  result.provenance.libraries["ceres"] = solver_version();

  if (!options.output_directory.empty())
    write_fit(study, scene, options, bench.pupil, bench.nominal, &result);
  return result;
}

}  // namespace aberfit
