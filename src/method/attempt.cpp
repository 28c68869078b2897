#include "aberfit/method/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "aberfit/core/random.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/spectrum_target.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

// Waves need a grid as fine as the light of everything that will be asked of it.
double grid_pitch(const Study& study, const Scene& scene, const TermSet& terms, const TargetSets& targets) {
  if (scene.use.model != FocusModel::kWaves) return 0;
  std::vector<Target> all = targets.fitted;
  all.insert(all.end(), targets.guides.begin(), targets.guides.end());
  all.insert(all.end(), targets.held_out.begin(), targets.held_out.end());
  return wave_pitch(study, terms, all);
}

// Ends a fit whose worst mismatch stays well above the tolerances.
class StallWatch {
 public:
  explicit StallWatch(FocusModel model) : creeping_is_stalling_(model == FocusModel::kWaves) {}

  bool stalled(const FitProgress& p) {
    if (p.worst_mismatch < (1 - kWorthwhile) * best_) {
      best_ = p.worst_mismatch;
      since_ = p.iteration;
    }
    if (p.worst_mismatch < (1 - kCreep) * crept_to_) {
      crept_to_ = p.worst_mismatch;
      crept_at_ = p.iteration;
    }
    if (best_ > kWellAbove) return p.iteration - since_ >= kPatience;
    return creeping_is_stalling_ && p.worst_mismatch > 1 && p.iteration - crept_at_ >= kCreepPatience;
  }

 private:
  // Fits that pass fell by more in every twelve iterations until they were at 2 tolerances (orders 2 to 31 of
  // fits/paper-physical); the ones that do not may run to the last iteration.
  static constexpr double kWorthwhile = 0.1, kWellAbove = 2;
  static constexpr int kPatience = 12;
  // An iteration through waves costs as much as a whole fit of rays; without this a set that ends at 1.04
  // tolerances took 14 s beside 5 s of one that passed (fits/smooth-waves, n <= 25).
  static constexpr double kCreep = 0.05;
  static constexpr int kCreepPatience = 6;
  bool creeping_is_stalling_;
  double best_ = std::numeric_limits<double>::infinity(), crept_to_ = best_;
  int since_ = 0, crept_at_ = 0;
};

// lowest: of the worst mismatches that the fit has been through.
FitOptions fit_options(const Study& study, const RunOptions& options, const Effort& effort, FocusModel model,
                       int threads, int tries, double* lowest) {
  FitOptions fit;
  fit.prior = study.fit.prior;
  fit.max_iterations = std::min(study.fit.max_iterations, effort.most_iterations);
  fit.bound = study.fit.bound_sigmas;
  fit.threads = threads;
  if (options.progress || effort.give_up_on_stall) {
    auto watch = std::make_shared<StallWatch>(model);
    fit.progress = [&options, &effort, watch, tries, lowest](const FitProgress& p) {
      *lowest = std::min(*lowest, p.worst_mismatch);
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

// Tries the seeded starts in turn and keeps the cheapest; stops at the first that meets every tolerance.
FitResult fit_from_starts(const Study& study, const FitProblem& problem, const RunOptions& options,
                          const Effort& effort, int threads, Eigen::VectorXd* start, double* lowest) {
  FitResult best;
  for (int k = 0; k < study.fit.starts; ++k) {
    const std::uint64_t seed =
        k == 0 ? study.fit.seed : RandomStream(study.fit.seed, "starts").bits(std::uint64_t(k));
    const Eigen::VectorXd white = effort.warm.size() > 0 ? effort.warm
                                  : study.fit.start == FitStart::kZero
                                      ? Eigen::VectorXd::Zero(problem.prior.size()).eval()
                                      : draw_white(problem.prior.size(), seed);
    const FitOptions how = fit_options(study, options, effort, problem.model, threads, k, lowest);
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

// Largest |S - T| / tolerance by the criterion the fit is stopped with, PSD bins included.
double worst_mismatch(const FitProblem& problem, const FitResult& fit) {
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

// Statistics on rays the fit has not seen, and the verdict on them.
void judge_on_fresh_rays(const Study& study, const TargetSets& targets, const RunOptions& options,
                         int threads, Attempt* attempt) {
  if (options.progress) options.progress("fresh rays");
  ResultDocument& result = attempt->result;
  std::vector<Statistic> judged = statistics_of(targets.fitted);
  for (const Target& target : targets.held_out) judged.push_back(target.statistic);
  attempt->fresh =
      evaluate_fresh(study, attempt->bench->model, attempt->bench->pitch, result.terms,
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

}  // namespace

Workbench::Workbench(const Study& study, FocusModel by, double grid_pitch, const TermSet& terms, int threads)
    : model(by),
      pitch(grid_pitch),
      pupil(focus_pupil(study, by, grid_pitch)),
      surface(terms, pupil, focus_operator(by, threads)),
      nominal(trace_nominal(study.mirror, pupil)) {}

SurfaceField Workbench::field(const Eigen::VectorXd& coefficients) const {
  SurfaceField result;
  surface.apply(coefficients, &result);
  return result;
}

Eigen::VectorXd Workbench::exact(const Study& study, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads,
                                 Warnings* warnings) const {
  if (model != FocusModel::kRays)
    return focus_statistics(focus(study), coefficients, statistics, threads, warnings);
  const SurfaceField f = field(coefficients);
  const RayBundle rays = trace(study.mirror, pupil, f);
  return evaluate_exact({rays, nominal, f.height, study.trace.centre}, statistics, threads, warnings);
}

LightPath Workbench::focus(const Study& study) const {
  return {study.mirror, pupil, surface, model, study.wavelength, &study.aperture, study.trace.centre};
}

bool has_solution(const FitResult& fit) {
  return fit.status == FitStatus::kConverged || fit.status == FitStatus::kNotConverged;
}

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
      study, scene.use.model, grid_pitch(study, scene, result.terms, targets), result.terms, threads);
  const Workbench& bench = *attempt.bench;
  result.rays = bench.pupil.size();

  const SpectrumTarget spectrum = make_spectrum_target(study, scene, result.terms, prior, threads);
  FitProblem problem{study.mirror,   bench.pupil,    bench.surface,      prior,
                     targets.fitted, targets.guides, study.trace.centre, scene.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  problem.model = bench.model;
  problem.wavelength = study.wavelength;
  problem.aperture = &study.aperture;
  Eigen::VectorXd start;
  double lowest = HUGE_VAL;  // what is known of a fit that was given up
  result.fit = fit_from_starts(study, problem, options, effort, threads, &start, &lowest);
  attempt.mismatch = has_solution(result.fit) ? worst_mismatch(problem, result.fit) : lowest;
  attempt.met = result.fit.status == FitStatus::kConverged && within_tolerance(problem, result.fit, 1.0);
  const std::vector<Statistic> fitted = statistics_of(targets.fitted);
  result.start = bench.exact(study, prior.colour(start), fitted, threads, nullptr);
  for (Eigen::Index b = 0; b < result.fit.spectrum.size(); ++b)
    result.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b], result.fit.spectrum[b],
                               spectrum.tolerance[b]});
  result.fitted = bench.exact(study, result.fit.coefficients, fitted, threads, &result.warnings);
  return attempt;
}

Attempt fit_on_enough_rays(Study study, const Scene& scene, const TargetSets& targets,
                           const RunOptions& options, const Effort& effort, bool judge_always, int threads) {
  double captured = 0;
  // The light itself says how fine a grid waves need.
  if (scene.use.model == FocusModel::kWaves) study.trace.automatic_rays = false;
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

}  // namespace aberfit
