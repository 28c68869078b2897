#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/report/plots.h"
#include "aberfit/scatter/ray_perturbation.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/run.h"
#include "judge.h"
#include "outputs.h"
#include "ray_count.h"
#include "run_map_fit.h"
#include "scene.h"
#include "spectrum_target.h"
#include "term_search.h"
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

// How far a fit goes. The default is the fit of a study with explicit terms, to the last bit.
struct Effort {
  int most_iterations = 1 << 30;
  Eigen::VectorXd warm;           // white coordinates to start from instead of a draw
  bool give_up_on_stall = false;  // a search has other sets to try
};

// Ends a fit whose worst mismatch stays well above the tolerances.
class StallWatch {
 public:
  bool stalled(const FitProgress& p) {
    if (p.worst_mismatch < (1 - kWorthwhile) * best_) {
      best_ = p.worst_mismatch;
      since_ = p.iteration;
    }
    return best_ > kWellAbove && p.iteration - since_ >= kPatience;
  }

 private:
  // Fits that pass fell by more in every twelve iterations until they were at 2 tolerances (orders 2 to 31 of
  // fits/paper-physical); the ones that do not may run to the last iteration.
  static constexpr double kWorthwhile = 0.1, kWellAbove = 2;
  static constexpr int kPatience = 12;
  double best_ = std::numeric_limits<double>::infinity();
  int since_ = 0;
};

FitOptions fit_options(const Study& study, const RunOptions& options, const Effort& effort, int threads,
                       int tries) {
  FitOptions fit;
  fit.prior = study.fit.prior;
  fit.max_iterations = std::min(study.fit.max_iterations, effort.most_iterations);
  fit.bound = study.fit.bound_sigmas;
  fit.threads = threads;
  if (options.progress || effort.give_up_on_stall) {
    auto watch = std::make_shared<StallWatch>();
    fit.progress = [&options, &effort, watch, tries](const FitProgress& p) {
      if (effort.give_up_on_stall && watch->stalled(p)) return false;
      if (!options.progress) return true;
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
                          const Effort& effort, int threads, Eigen::VectorXd* start) {
  FitResult best;
  for (int k = 0; k < study.fit.starts; ++k) {
    const std::uint64_t seed =
        k == 0 ? study.fit.seed : RandomStream(study.fit.seed, "starts").bits(std::uint64_t(k));
    const Eigen::VectorXd white = effort.warm.size() > 0 ? effort.warm
                                  : study.fit.start == FitStart::kZero
                                      ? Eigen::VectorXd::Zero(problem.prior.size()).eval()
                                      : draw_white(problem.prior.size(), seed);
    const FitOptions how = fit_options(study, options, effort, threads, k);
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

// One fit of explicit terms on so many rays, and what goes on from it.
struct Attempt {
  ResultDocument result;
  std::shared_ptr<const Workbench> bench;
  CoefficientPrior prior;
  FreshStatistics fresh;  // empty where the fit was not judged
  double captured = 0;
  double mismatch = HUGE_VAL;  // worst, in tolerances
  bool met = false;            // every tolerance
};

// Largest |S - T| / tolerance by the criterion the fit is stopped with, PSD bins included.
double worst_mismatch(const FitProblem& problem, const FitResult& fit) {
  if (!has_solution(fit)) return HUGE_VAL;
  double worst = 0;
  for (Eigen::Index k = 0; k < fit.smooth_statistics.size(); ++k) {
    const Target& target = problem.targets[std::size_t(k)];
    worst = std::max(worst, std::abs(fit.smooth_statistics[k] - target.value) / target.tolerance);
  }
  for (Eigen::Index b = 0; b < fit.spectrum.size(); ++b)
    worst = std::max(worst, std::abs(std::log(fit.spectrum[b] / problem.spectrum_target[b])) /
                                problem.spectrum_tolerance[b]);
  return worst;
}

// Fits what `study` names.
Attempt attempt_fit(const Study& study, const Scene& scene, const TargetSets& targets,
                    const RunOptions& options, const Effort& effort, int threads) {
  const auto say = [&](const std::string& line) {
    if (options.progress) options.progress(line);
  };
  Attempt attempt;
  ResultDocument& result = attempt.result;
  result.has_roughness = scene.psd.has_value();
  result.scene = scene.numbers;
  describe_models(scene, targets.theory, &result);
  result.targets = targets.fitted;
  result.radius = scene.radius;
  result.terms = make_terms(study, scene, &attempt.captured);
  result.warnings = scene_warnings(study, scene, result.terms, attempt.captured);

  say("prior");
  attempt.prior = make_study_prior(study, scene, result.terms);
  const CoefficientPrior& prior = attempt.prior;
  attempt.bench = std::make_shared<const Workbench>(
      study, scene.use.physics, grid_pitch(study, scene, result.terms, targets), result.terms, threads);
  const Workbench& bench = *attempt.bench;
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
  result.fit = fit_from_starts(study, problem, options, effort, threads, &start);
  attempt.mismatch = worst_mismatch(problem, result.fit);
  attempt.met = result.fit.status == FitStatus::kConverged && within_tolerance(problem, result.fit, 1.0);
  const std::vector<Statistic> fitted = statistics_of(targets.fitted);
  result.start = bench.exact(study, prior.colour(start), fitted, threads, nullptr);
  for (Eigen::Index b = 0; b < result.fit.spectrum.size(); ++b)
    result.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b], result.fit.spectrum[b],
                               spectrum.tolerance[b]});
  result.fitted = bench.exact(study, result.fit.coefficients, fitted, threads, &result.warnings);
  return attempt;
}

// Statistics on rays the fit has not seen, and the verdict on them.
void judge_on_fresh_rays(const Study& study, const TargetSets& targets, const RunOptions& options,
                         int threads, Attempt* attempt) {
  if (options.progress) options.progress("fresh rays");
  ResultDocument& result = attempt->result;
  std::vector<Statistic> judged = statistics_of(targets.fitted);
  for (const Target& target : targets.held_out) judged.push_back(target.statistic);
  attempt->fresh =
      evaluate_fresh(study, attempt->bench->physics, attempt->bench->pitch, result.terms,
                     result.fit.coefficients, judged, 4 * result.rays, threads, &result.warnings);
  judge(study, targets, attempt->fresh, &result);
}

// How far the fit's own rays are from fresh ones, and those from each other.
RayChoice ray_choice(const Study& study, const Attempt& attempt) {
  RayChoice choice;
  choice.automatic = study.trace.automatic_rays;
  choice.allowed = kRayShareOfMargin * study.equivalence.margin;
  choice.gap = choice.sampling_error = 0;
  const ResultDocument& result = attempt.result;
  for (Eigen::Index k = 0; k < result.fitted.size(); ++k) {
    const double scale = std::abs(result.targets[std::size_t(k)].value);
    if (!(scale > 0)) continue;
    choice.gap = std::max(choice.gap, std::abs(result.fitted[k] - attempt.fresh.value[k]) / scale);
    choice.sampling_error = std::max(choice.sampling_error, attempt.fresh.standard_error[k] / scale);
  }
  return choice;
}

// The fit of explicit terms: on the study's rays, or on more and more until fresh ones say the same.
// `judge_always`: a search does not care what fresh rays say of a set that misses its tolerances.
Attempt fit_on_enough_rays(Study study, const Scene& scene, const TargetSets& targets,
                           const RunOptions& options, const Effort& effort, bool judge_always, int threads) {
  double captured = 0;
  // The light itself says how fine a grid waves need.
  if (scene.use.physics == FocusPhysics::kWaves) study.trace.automatic_rays = false;
  if (study.trace.automatic_rays)
    study.trace.pupil.rays = first_rays(make_terms(study, scene, &captured).size());
  for (;;) {
    Attempt attempt = attempt_fit(study, scene, targets, options, effort, threads);
    if (judge_always || attempt.met) judge_on_fresh_rays(study, targets, options, threads, &attempt);
    const bool judged = attempt.fresh.rays > 0;
    if (judged) attempt.result.ray_choice = ray_choice(study, attempt);
    if (!judged || !study.trace.automatic_rays ||
        explain_rays(study.trace.pupil.rays, attempt.result.verdict, &*attempt.result.ray_choice)) {
      Study used = study;
      used.trace.automatic_rays = false;
      attempt.result.study = resolved_study(used);
      return attempt;
    }
    study.trace.pupil.rays = more_rays(study.trace.pupil.rays);
  }
}

FrontierPoint frontier_point(const Attempt& attempt, double seconds) {
  FrontierPoint point;
  point.terms = attempt.result.terms.size();
  point.rays = attempt.result.rays;
  point.fitted_mismatch = attempt.mismatch;
  point.seconds = seconds;
  if (attempt.fresh.rays == 0) return point;
  point.verdict = attempt.result.verdict;
  point.passes = attempt.met && attempt.result.verdict == Verdict::kEquivalent;
  double worst = NAN;
  for (const EquivalenceMetric& metric : attempt.result.metrics)
    if (metric.held_out) worst = std::fmax(worst, std::abs(metric.relative_difference));
  point.held_out_mismatch = worst;
  return point;
}

// White coordinates of `terms` that continue a fit of fewer Zernikes: its coefficients, and the seeded draw's
// for the new orders.
Eigen::VectorXd continued(const Study& study, const Attempt& before, const TermSet& terms,
                          const CoefficientPrior& prior) {
  Eigen::VectorXd coefficients = prior.colour(draw_white(prior.size(), study.fit.seed));
  const Eigen::Index n = std::min(before.result.fit.coefficients.size(), Eigen::Index(terms.zernike.size()));
  coefficients.head(n) = before.result.fit.coefficients.head(n);
  return prior.whiten(coefficients);
}

// `"terms": "auto"`: the fewest that do.
Attempt fit_fewest_terms(const Study& study, const Scene& scene, const TargetSets& targets,
                         const RunOptions& options, int threads) {
  using Clock = std::chrono::steady_clock;
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  std::optional<Attempt> last_screened, best;
  TermTrials trials;
  trials.screen = [&](const Study& with) {
    const auto begin = Clock::now();
    Study cheap = with;
    double captured = 0;
    const TermSet terms = make_terms(cheap, scene, &captured);
    if (study.target.psd && (with.terms.zernike->n_max.value() + 1) / (2 * EIGEN_PI * scene.radius) <=
                                study.target.psd->f_min.value_or(scene.psd->f_min())) {
      // The terms end below the PSD bins that are asked for.
      FrontierPoint point;
      point.terms = terms.size();
      point.fitted_mismatch = HUGE_VAL;
      point.screened = true;
      return point;
    }
    cheap.trace.pupil.rays = screening_rays(terms.size());
    cheap.fit.starts = 1;
    Effort effort;
    effort.most_iterations = kScreeningIterations;
    if (last_screened && last_screened->result.terms.size() < terms.size())
      effort.warm = continued(study, *last_screened, terms, make_study_prior(cheap, scene, terms));
    Attempt attempt = attempt_fit(cheap, scene, targets, options, effort, threads);
    FrontierPoint point = frontier_point(attempt, since(begin));
    point.screened = true;
    if (has_solution(attempt.result.fit)) last_screened = std::move(attempt);
    return point;
  };
  trials.confirm = [&](const Study& with) {
    const auto begin = Clock::now();
    Effort effort;
    effort.give_up_on_stall = true;
    Attempt attempt = fit_on_enough_rays(with, scene, targets, options, effort, false, threads);
    const FrontierPoint point = frontier_point(attempt, since(begin));
    // Kept: the fewest that pass; a fit that is needed again otherwise is made again.
    if (point.passes && (!best || point.terms < best->result.terms.size())) best = std::move(attempt);
    return point;
  };
  const Frontier frontier = search_terms(study, expected_orders(scene), trials);
  if (!best) {
    const auto chosen = std::find_if(frontier.points.begin(), frontier.points.end(),
                                     [](const FrontierPoint& point) { return point.chosen; });
    best = fit_on_enough_rays(chosen->family == "fourier" ? with_fourier_modes(study, chosen->order)
                                                          : with_zernikes(study, chosen->order),
                              scene, targets, options, {}, true, threads);
  } else {
    // The band and the frontier say what a set of fewest terms leaves out; more terms are not called for.
    std::erase_if(best->result.warnings, [](const Warning& w) { return w.code == "truncated-terms"; });
  }
  best->result.frontier = frontier;
  return std::move(*best);
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
    write_fit(study, scene, options, attempt.bench->pupil, attempt.bench->nominal, &result);
  return std::move(result);
}

}  // namespace aberfit
