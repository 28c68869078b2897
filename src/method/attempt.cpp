#include "aberfit/method/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/random.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fresh_verdict.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/spectrum_target.h"
#include "fit_grids.h"
#include "fit_progress.h"

namespace aberfit {
using namespace internal;

namespace {

// Standard deviations of fitted values, converted to the units of the shown values.
Eigen::VectorXd shown_std(const std::vector<Target>& targets, const Eigen::VectorXd& fitted) {
  Eigen::VectorXd shown = fitted;
  for (Eigen::Index k = 0; k < shown.size(); ++k) {
    const Target& target = targets[std::size_t(k)];
    if (target.curve_slope && std::holds_alternative<EncircledEnergyRadius>(target.statistic))
      shown[k] *= target.value / *target.curve_slope;
  }
  return shown;
}

// Fraction of the margin for the difference between the fit's grid and the judging grid. Errors grow as the
// square of the pitch, so a judging grid coarser than the safe one shows only part of the fit's error.
double allowed_gap(double of_fit, double of_judge) {  // pitches over the safe one
  if (of_judge <= 1) return law::kGridShareOfMargin;
  return law::kGridShareOfMargin * (of_fit * of_fit - of_judge * of_judge) /
         std::max(1e-3, of_fit * of_fit - 1);
}

// Detects a fit that no longer improves, see law::kPatience.
class RestWatch {
 public:
  bool rests(const FitProgress& p) {
    if (p.solve != solve_) best_ = kInfinity;  // the mismatch starts anew with another smoothing
    solve_ = p.solve;
    if (p.worst_mismatch < law::kWorthwhile * best_) {
      best_ = p.worst_mismatch;
      since_ = p.iteration;
    }
    return best_ > 1 && p.iteration - since_ >= law::kPatience;
  }

 private:
  double best_ = kInfinity;
  int since_ = 0, solve_ = 0;
};

// lowest: smallest of the worst mismatches during the fit.
FitOptions fit_options(const FitCase& of, const FitPlan& plan, double* lowest) {
  FitOptions fit;
  fit.prior = of.task.fit.prior;
  fit.max_iterations = plan.most_iterations;
  fit.bound = of.task.fit.bound_sigmas;
  fit.threads = of.context.threads;
  if (of.ground.use.model == FocusModel::kWaves) {
    fit.stop_at = 1;
    fit.prior_weight = law::kWavePriorWeight;
    fit.guides_within = 1;
  }
  const auto watch = std::make_shared<RestWatch>();
  fit.progress = [&of, watch, lowest,
                  line = FitProgressLine(plan.terms->terms.size(), plan.set, plan.most_sets, plan.start)](
                     const FitProgress& p) mutable {
    *lowest = std::min(*lowest, p.worst_mismatch);
    of.context.say(line(p));
    return !of.context.stopped() && !watch->rests(p);
  };
  return fit;
}

Eigen::VectorXd first_draw(const FitSpec& asked, const FitPlan& plan) {
  const Eigen::Index size = plan.terms->prior.size();
  if (plan.warm.size() > 0) return plan.warm;
  if (asked.start == FitStart::kZero) return Eigen::VectorXd::Zero(size);
  return draw_white(size, plan.start == 0
                              ? asked.seed
                              : RandomStream(asked.seed, "starts").bits(std::uint64_t(plan.start)));
}

// Largest |S - T| / tolerance; infinite where a statistic has no value.
double worst_mismatch(const std::vector<Target>& aims, const Eigen::VectorXd& values) {
  double worst = 0;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const Target& aim = aims[std::size_t(k)];
    const double mismatch = std::abs(values[k] - aim.value) / aim.tolerance;
    worst = std::isnan(mismatch) ? kInfinity : std::max(worst, mismatch);
  }
  return worst;
}

// The same with PSD bins, as in the stopping criterion of the fit.
double worst_mismatch(const FitProblem& problem, const FitResult& fit) {
  double worst = worst_mismatch(problem.targets, fit.smooth_statistics);
  for (Eigen::Index b = 0; b < fit.spectrum.size(); ++b)
    worst = std::max(worst, std::abs(std::log(fit.spectrum[b] / problem.spectrum_target[b])) /
                                problem.spectrum_tolerance[b]);
  return worst;
}

RayChoice ray_choice(const FitCase& of, const FitPlan& plan, const Attempt& attempt) {
  RayChoice choice;
  choice.automatic = plan.automatic_rays;
  choice.allowed = law::kRayShareOfMargin * of.task.equivalence.margin;
  choice.gap = choice.sampling_error = 0;
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  const Eigen::VectorXd fresh = judged.judged(attempt.first_seen),
                        error = judged.judged(attempt.fresh.standard_error);
  for (Eigen::Index k = 0; k < attempt.own.size(); ++k) {
    const double scale = aim_of(of.targets.fitted[std::size_t(k)]).scale;
    if (!(scale > 0)) continue;
    // A statistic without a value on either sample counts as infinitely different.
    const double gap = std::abs(attempt.own[k] - fresh[k]) / scale, of_fresh = error[k] / scale;
    choice.gap = std::isnan(gap) ? kInfinity : std::max(choice.gap, gap);
    choice.sampling_error = std::isnan(of_fresh) ? kInfinity : std::max(choice.sampling_error, of_fresh);
  }
  return choice;
}

FitProblem problem_of(const FitCase& of, const Workbench& bench, const CoefficientPrior& prior,
                      const SpectrumTarget& spectrum) {
  FitProblem problem{bench.focus(of.task), prior, aims_of(of.targets.fitted), aims_of(of.targets.guides),
                     of.ground.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  return problem;
}

// Returns whether the sample of a fit was fine enough, judged by the fresh sample. Writes `ray_choice`.
bool is_fine_enough(const FitCase& of, const FitPlan& plan, Attempt* attempt) {
  RayChoice& choice = attempt->result.choices.rays.emplace(ray_choice(of, plan, *attempt));
  if (of.ground.use.model != FocusModel::kWaves)
    return explain_rays(rays_of(plan.pupil), attempt->result.judgement.verdict, &choice) ||
           !plan.automatic_rays;
  const double safe = grid_pitch(of, attempt->result.fitted.terms, 1);
  const double share = allowed_gap(attempt->bench->pitch / safe, attempt->judging_coarsening);
  choice.allowed = share * of.task.equivalence.margin;
  return explain_cells(attempt->result.fitted.rays, share, &choice) ||
         plan.coarsening <= law::kLeastCoarsening;
}

// The same plan with more rays from the same start, or on the next finer grid from the fitted surface.
FitPlan on_a_finer_sample(const FitCase& of, FitPlan plan, const Attempt& attempt) {
  if (of.ground.use.model != FocusModel::kWaves) {
    plan.pupil.rays = more_rays(rays_of(plan.pupil));
    return plan;
  }
  plan.coarsening /= std::numbers::sqrt2;
  if (has_solution(attempt.result.fitted.fit)) plan.warm = attempt.result.fitted.fit.white;
  return plan;
}

// Phases that change too much between grid cells have no diffraction pattern; a finer grid may have one.
bool has_no_pattern(const FitCase& of, const FitPlan& plan, const Attempt& attempt) {
  const FitStatus status = attempt.result.fitted.fit.status;
  return of.ground.use.model == FocusModel::kWaves && plan.coarsening > law::kLeastCoarsening &&
         (status == FitStatus::kFailed ||
          (status == FitStatus::kDegenerate && of.task.fit.start != FitStart::kZero));
}

}  // namespace

double internal::grid_pitch(const FitCase& of, const TermSet& terms, double coarsening) {
  if (of.ground.use.model != FocusModel::kWaves) return 0;
  return wave_pitch(of.task, terms, all_targets(of.targets), of.ground.split.get(), coarsening);
}

bool is_equivalent(const Attempt& attempt) {
  return attempt.fresh.rays > 0 && attempt.result.judgement.verdict == Verdict::kEquivalent;
}

double distance_to_margin(const Attempt& attempt) {
  double worst = attempt.fresh.rays > 0 ? 0 : attempt.mismatch;
  for (const EquivalenceMetric& metric : attempt.result.judgement.metrics) {
    const double distance = std::abs(metric.difference) / metric.margin;
    worst = std::isnan(distance) ? kInfinity : std::max(worst, distance);
  }
  return worst;
}

void describe_scene(const FitCase& of, double captured, FitOutcome* result) {
  result->has_roughness = of.ground.psd.has_value();
  result->scene = scene_facts(of.ground, of.targets.theory);
  result->judgement.light_decides = of.ground.use.light_decides;
  result->fitted.targets = of.targets.fitted;
  result->band.shares = of.ground.shares;
  const Warnings scene = scene_warnings(of.task, of.ground, result->fitted.terms, captured);
  for (const Warnings* told : {&scene, &of.targets.warnings})
    result->warnings.insert(result->warnings.end(), told->begin(), told->end());
}

FitOutcome outcome_of(const FitCase& of, const FitPlan& plan) {
  FitOutcome result;
  result.fitted.radius = of.ground.radius;
  result.fitted.terms = plan.terms->terms;
  result.choices.values = {plan.terms->asked, rays_of(plan.pupil), plan.start + 1};
  result.choices.values.terms.band.rule = BandRule::kAll;
  if (of.ground.split) result.choices.values.terms.band = {BandRule::kCut, of.ground.split->cut()};
  result.judgement.confidence = of.task.equivalence.confidence;
  describe_scene(of, plan.terms->captured, &result);
  return result;
}

Workbench::Workbench(const Task& task, FocusModel by, const PupilOptions& rays, double grid_pitch,
                     const TermSet& terms, int threads, std::shared_ptr<const BandSplit> split)
    : model(by),
      scatter(std::move(split)),
      pitch(grid_pitch),
      pupil(focus_pupil(task, by, rays, grid_pitch)),
      surface(terms, pupil, focus_operator(by, threads)) {}

SurfaceField Workbench::field(const Eigen::VectorXd& coefficients) const {
  SurfaceField result;
  surface.apply(coefficients, &result);
  return result;
}

Eigen::VectorXd Workbench::exact(const Task& task, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads,
                                 Warnings* warnings) const {
  return focus_statistics(focus(task), coefficients, statistics, threads, warnings);
}

LightPath Workbench::focus(const Task& task) const {
  return {task.mirror,     pupil,          surface,           model,
          task.wavelength, &task.aperture, task.trace.centre, kMostAliasedBeforeAFiner,
          nullptr,         scatter,        single_precision};
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
  const auto made = std::make_shared<Workbench>(of.task, of.ground.use.model, plan.pupil,
                                                grid_pitch(of, result.fitted.terms, plan.coarsening),
                                                result.fitted.terms, threads, of.ground.split);
  made->single_precision = in_single_precision(of.ground.use.model, of.targets, made->pupil.size());
  attempt.bench = made;
  const Workbench& bench = *attempt.bench;
  result.fitted.rays = bench.pupil.size();

  const SpectrumTarget spectrum =
      make_spectrum_target(of.task, of.ground, result.fitted.terms, prior, threads);
  const FitProblem problem = problem_of(of, bench, prior, spectrum);
  double lowest = HUGE_VAL;  // smallest mismatch of a fit that was ended early
  const Eigen::VectorXd draw = first_draw(of.task.fit, plan);
  result.fitted.fit = calibrate(problem, draw, fit_options(of, plan, &lowest));
  if (result.fitted.fit.status == FitStatus::kCancelled && !of.context.stopped()) {
    result.fitted.fit.status = FitStatus::kNotConverged;
    result.fitted.fit.message = fmt::format(
        "stopped after {} iterations; in the last {} the largest mismatch did not fall below {:.3g} "
        "tolerances",
        result.fitted.fit.iterations, law::kPatience, lowest);
  }
  attempt.mismatch = has_solution(result.fitted.fit) ? worst_mismatch(problem, result.fitted.fit) : lowest;
  const JudgedSet fitted(of.targets.fitted, {});
  result.fitted.start =
      fitted.shown(bench.exact(of.task, prior.colour(draw), fitted.statistics(), threads, nullptr));
  for (Eigen::Index b = 0; b < result.fitted.fit.spectrum.size(); ++b)
    result.fitted.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b],
                                      result.fitted.fit.spectrum[b], spectrum.tolerance[b]});
  const Eigen::VectorXd own = bench.exact(of.task, result.fitted.fit.coefficients, fitted.statistics(),
                                          threads, &attempt.own_warnings);
  result.fitted.values = fitted.shown(own);
  attempt.own = fitted.judged(own);
  result.fitted.posterior_std = shown_std(of.targets.fitted, result.fitted.fit.statistic_std);
  return attempt;
}

Attempt fit_on_a_fine_enough_sample(const FitCase& of, FitPlan plan) {
  if (of.ground.use.model == FocusModel::kWaves)
    plan.coarsening = law::kFirstCoarsening;
  else if (plan.automatic_rays)
    plan.pupil.rays = first_rays(plan.terms->terms.size());
  std::optional<Attempt> judged;  // on a coarser sample
  for (;;) {
    Attempt attempt = attempt_fit(of, plan);
    if (of.context.stopped() && judged) return std::move(*judged);
    if (of.context.stopped() || !has_no_pattern(of, plan, attempt)) {
      judge_on_fresh_rays(of, &attempt);
      if (is_fine_enough(of, plan, &attempt) || of.context.stopped()) return attempt;
    }
    plan = on_a_finer_sample(of, std::move(plan), attempt);
    if (attempt.fresh.rays > 0) judged = std::move(attempt);
  }
}

}  // namespace aberfit
