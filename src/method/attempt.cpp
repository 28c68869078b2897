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

namespace aberfit {
namespace {

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

// Waves need a grid as fine as the light of everything that will be asked of it.
double grid_pitch(const FitCase& of, const TermSet& terms) {
  if (of.ground.use.model != FocusModel::kWaves) return 0;
  std::vector<Target> all = of.targets.fitted;
  all.insert(all.end(), of.targets.guides.begin(), of.targets.guides.end());
  all.insert(all.end(), of.targets.held_out.begin(), of.targets.held_out.end());
  return wave_pitch(of.task, terms, all);
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
FitOptions fit_options(const FitCase& of, const FitPlan& plan, int tries, double* lowest) {
  FitOptions fit;
  fit.prior = of.task.fit.prior;
  fit.max_iterations = plan.most_iterations;
  fit.bound = of.task.fit.bound_sigmas;
  fit.threads = of.context.threads;
  if (!of.context.progress && !plan.give_up_on_stall) return fit;
  auto watch = std::make_shared<StallWatch>(of.ground.use.model);
  fit.progress = [&of, &plan, watch, tries, lowest](const FitProgress& p) {
    *lowest = std::min(*lowest, p.worst_mismatch);
    if (plan.give_up_on_stall && watch->stalled(p)) return false;
    if (!of.context.progress) return true;
    of.context.say(fmt::format("fit{}: iteration {}, worst mismatch {:.3g} tolerances, {:.1f} s",
                               tries > 0 ? fmt::format(" (start {})", tries + 1) : "", p.iteration,
                               p.worst_mismatch, p.seconds));
    return true;
  };
  return fit;
}

// Tries the seeded starts in turn and keeps the cheapest; stops at the first that meets every tolerance.
FitResult fit_from_starts(const FitCase& of, const FitPlan& plan, const FitProblem& problem,
                          Eigen::VectorXd* start, double* lowest) {
  const FitSpec& asked = of.task.fit;
  FitResult best;
  for (int k = 0; k < plan.starts; ++k) {
    const std::uint64_t seed =
        k == 0 ? asked.seed : RandomStream(asked.seed, "starts").bits(std::uint64_t(k));
    const Eigen::VectorXd white = plan.warm.size() > 0 ? plan.warm
                                  : asked.start == FitStart::kZero
                                      ? Eigen::VectorXd::Zero(problem.prior.size()).eval()
                                      : draw_white(problem.prior.size(), seed);
    const FitOptions how = fit_options(of, plan, k, lowest);
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
void judge(const FitCase& of, const FreshStatistics& fresh, FitOutcome* result) {
  const EquivalenceSpec& asked = of.task.equivalence;
  const auto add = [&](const Target& target, bool held_out, Eigen::Index at) {
    result->metrics.push_back(tost(statistic_name(target.statistic), held_out, target.value,
                                   target.standard_error, fresh.value[at], fresh.standard_error[at],
                                   asked.margin, asked.confidence,
                                   {target.degrees_of_freedom, fresh.degrees_of_freedom}));
  };
  Eigen::Index at = 0;
  for (const Target& target : of.targets.fitted) add(target, false, at++);
  for (const Target& target : of.targets.held_out) add(target, true, at++);
  result->validated = fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  result->verdict = overall(result->metrics);
}

// Statistics on rays the fit has not seen, and the verdict on them.
void judge_on_fresh_rays(const FitCase& of, Attempt* attempt) {
  of.context.say("fresh rays");
  FitOutcome& result = attempt->result;
  std::vector<Statistic> judged = statistics_of(of.targets.fitted);
  for (const Target& target : of.targets.held_out) judged.push_back(target.statistic);
  const FreshPupil pupil{attempt->bench->model, 4 * result.rays, of.task.trace.pupil.seed,
                         attempt->bench->pitch};
  attempt->fresh = statistics_with_error(lit_mirror(of.task), pupil, result.terms, result.fit.coefficients,
                                         judged, of.context.threads, &result.warnings);
  judge(of, attempt->fresh, &result);
}

// How far the fit's own rays are from fresh ones, and those from each other.
RayChoice ray_choice(const Task& task, const FitPlan& plan, const Attempt& attempt) {
  RayChoice choice;
  choice.automatic = plan.automatic_rays;
  choice.allowed = kRayShareOfMargin * task.equivalence.margin;
  choice.gap = choice.sampling_error = 0;
  const FitOutcome& result = attempt.result;
  for (Eigen::Index k = 0; k < result.fitted.size(); ++k) {
    const double scale = std::abs(result.targets[std::size_t(k)].value);
    if (!(scale > 0)) continue;
    choice.gap = std::max(choice.gap, std::abs(result.fitted[k] - attempt.fresh.value[k]) / scale);
    choice.sampling_error = std::max(choice.sampling_error, attempt.fresh.standard_error[k] / scale);
  }
  return choice;
}

// What is known of a result before the solve.
FitOutcome outcome_of(const FitCase& of, const FitPlan& plan) {
  FitOutcome result;
  result.has_roughness = of.ground.psd.has_value();
  result.scene = of.ground.numbers;
  describe_models(of.ground, of.targets.theory, &result);
  result.targets = of.targets.fitted;
  result.radius = of.ground.radius;
  result.terms = plan.terms->terms;
  result.chosen = {plan.terms->asked, plan.pupil.rays};
  result.confidence = of.task.equivalence.confidence;
  result.warnings = scene_warnings(of.task, of.ground, result.terms, plan.terms->captured);
  return result;
}

FitProblem problem_of(const FitCase& of, const Workbench& bench, const CoefficientPrior& prior,
                      const SpectrumTarget& spectrum) {
  FitProblem problem{of.task.mirror,    bench.pupil,       bench.surface,        prior,
                     of.targets.fitted, of.targets.guides, of.task.trace.centre, of.ground.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  problem.model = bench.model;
  problem.wavelength = of.task.wavelength;
  problem.aperture = &of.task.aperture;
  return problem;
}

}  // namespace

Workbench::Workbench(const Task& task, FocusModel by, const PupilOptions& rays, double grid_pitch,
                     const TermSet& terms, int threads)
    : model(by),
      pitch(grid_pitch),
      pupil(focus_pupil(task, by, rays, grid_pitch)),
      surface(terms, pupil, focus_operator(by, threads)),
      nominal(trace_nominal(task.mirror, pupil)) {}

SurfaceField Workbench::field(const Eigen::VectorXd& coefficients) const {
  SurfaceField result;
  surface.apply(coefficients, &result);
  return result;
}

Eigen::VectorXd Workbench::exact(const Task& task, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads,
                                 Warnings* warnings) const {
  if (model != FocusModel::kRays)
    return focus_statistics(focus(task), coefficients, statistics, threads, warnings);
  const SurfaceField f = field(coefficients);
  const RayBundle rays = trace(task.mirror, pupil, f);
  return evaluate_exact({rays, nominal, f.height, task.trace.centre}, statistics, threads, warnings);
}

LightPath Workbench::focus(const Task& task) const {
  return {task.mirror, pupil, surface, model, task.wavelength, &task.aperture, task.trace.centre};
}

bool has_solution(const FitResult& fit) {
  return fit.status == FitStatus::kConverged || fit.status == FitStatus::kNotConverged;
}

Attempt attempt_fit(const FitCase& of, const FitPlan& plan) {
  const int threads = of.context.threads;
  const CoefficientPrior& prior = plan.terms->prior;
  Attempt attempt;
  attempt.terms = plan.terms;
  attempt.result = outcome_of(of, plan);
  FitOutcome& result = attempt.result;
  attempt.bench = std::make_shared<const Workbench>(of.task, of.ground.use.model, plan.pupil,
                                                    grid_pitch(of, result.terms), result.terms, threads);
  const Workbench& bench = *attempt.bench;
  result.rays = bench.pupil.size();

  const SpectrumTarget spectrum = make_spectrum_target(of.task, of.ground, result.terms, prior, threads);
  const FitProblem problem = problem_of(of, bench, prior, spectrum);
  Eigen::VectorXd start;
  double lowest = HUGE_VAL;  // what is known of a fit that was given up
  result.fit = fit_from_starts(of, plan, problem, &start, &lowest);
  attempt.mismatch = has_solution(result.fit) ? worst_mismatch(problem, result.fit) : lowest;
  attempt.met = result.fit.status == FitStatus::kConverged && within_tolerance(problem, result.fit, 1.0);
  const std::vector<Statistic> fitted = statistics_of(of.targets.fitted);
  result.start = bench.exact(of.task, prior.colour(start), fitted, threads, nullptr);
  for (Eigen::Index b = 0; b < result.fit.spectrum.size(); ++b)
    result.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b], result.fit.spectrum[b],
                               spectrum.tolerance[b]});
  result.fitted = bench.exact(of.task, result.fit.coefficients, fitted, threads, &result.warnings);
  return attempt;
}

Attempt fit_on_enough_rays(const FitCase& of, FitPlan plan, bool judge_always) {
  // The light itself says how fine a grid waves need.
  if (of.ground.use.model == FocusModel::kWaves) plan.automatic_rays = false;
  if (plan.automatic_rays) plan.pupil.rays = first_rays(plan.terms->terms.size());
  for (;;) {
    Attempt attempt = attempt_fit(of, plan);
    if (judge_always || attempt.met) judge_on_fresh_rays(of, &attempt);
    if (attempt.fresh.rays == 0) return attempt;
    RayChoice& choice = attempt.result.ray_choice.emplace(ray_choice(of.task, plan, attempt));
    if (!plan.automatic_rays || explain_rays(plan.pupil.rays, attempt.result.verdict, &choice))
      return attempt;
    plan.pupil.rays = more_rays(plan.pupil.rays);
  }
}

}  // namespace aberfit
