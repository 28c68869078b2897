#include "aberfit/method/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/random.h"
#include "aberfit/method/fresh_verdict.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/spectrum_target.h"
#include "aberfit/method/term_search.h"
#include "fit_grids.h"
#include "fit_progress.h"
#include "light_guides.h"
#include "ray_approach.h"
#include "stall_watch.h"

namespace aberfit {
using namespace internal;

namespace {

// Standard deviations of what is fitted, in the units of what is shown.
Eigen::VectorXd shown_std(const std::vector<Target>& targets, const Eigen::VectorXd& fitted) {
  Eigen::VectorXd shown = fitted;
  for (Eigen::Index k = 0; k < shown.size(); ++k) {
    const Target& target = targets[std::size_t(k)];
    if (target.curve_slope && std::holds_alternative<EncircledEnergyRadius>(target.statistic))
      shown[k] *= target.value / *target.curve_slope;
  }
  return shown;
}

// Of the last of the grids for waves, which is finer than the safe one.
constexpr double kLeastCoarsening = 0.6;
// Draws on a coarse grid have phases that alias at the rim, far out of focus. What that does to the surface
// the safe grid sees, and the fit goes on to a finer one.
constexpr double kAliasedInAFit = kMostAliasedBeforeAFiner;
// What the gap between the fit's grid and the safe one may take of the margin. Where a coarser one judges, a
// gap as the square of the pitch is smaller by what is left to the safe one.
constexpr double kGridShareOfMargin = 0.15;
double gap_share(double of_fit, double of_judge) {  // times the safe pitch
  if (of_judge <= 1) return kGridShareOfMargin;
  return kGridShareOfMargin * (of_fit * of_fit - of_judge * of_judge) / std::max(1e-3, of_fit * of_fit - 1);
}
// Few terms are kept at the edge of the tolerances by the prior: the README's study at n = 22 took 40
// iterations with a weight of 1, 16 with 0.3, beside guides that are looser since.
constexpr double kWavePriorWeight = 0.1;

// lowest: of the worst mismatches that the fit has been through.
// warm: the fit begins where another has led.
FitOptions fit_options(const FitCase& of, const FitPlan& plan, double met_within, int tries, bool warm,
                       double* lowest) {
  FitOptions fit;
  fit.prior = of.task.fit.prior;
  fit.max_iterations = plan.most_iterations;
  fit.bound = of.task.fit.bound_sigmas;
  fit.threads = of.context.threads;
  if (of.ground.use.model == FocusModel::kWaves) {
    fit.stop_at = met_within;
    fit.prior_weight = kWavePriorWeight;
    fit.guides_within = plan.guides_within / met_within;  // guides do not mind what targets may
  }
  const bool minds_stall = plan.on_stall != OnStall::kGoOn;
  if (!of.context.progress && !of.context.interrupted && !minds_stall) return fit;
  const FocusModel model = of.ground.use.model;
  auto watch = std::make_shared<StallWatch>(plan.on_stall == OnStall::kEnd
                                                ? StallWatch::patient(model, plan.most_iterations)
                                                : StallWatch(model, plan.most_iterations, warm, met_within));
  fit.progress = [&of, minds_stall, watch, lowest,
                  line =
                      FitProgressLine(plan.terms->terms.size(), 1, 0, tries)](const FitProgress& p) mutable {
    *lowest = std::min(*lowest, p.worst_mismatch);
    if (of.context.stopped() || (minds_stall && watch->stalled(p))) return false;
    of.context.say(line(p));
    return true;
  };
  return fit;
}

// What the seeded starts of a plan come to.
struct Fitted {
  FitResult fit;
  Eigen::VectorXd draw;              // that the fit began with, or what its plan begins with instead
  std::optional<RayApproach> begun;  // where rays have led it from there
};

// Tries the plan's seeded starts in turn and keeps the cheapest; stops at the first that meets every
// tolerance. lowest: of the worst mismatches that a fit has been through.
Fitted fit_from_starts(const FitCase& of, const FitPlan& plan, const Workbench& bench,
                       const FitProblem& problem, double* lowest) {
  const FitSpec& asked = of.task.fit;
  const bool by_rays = plan.warm.size() == 0 &&
                       begins_by_rays(of.task, of.ground, of.targets, bench.pupil.size(), bench.wide_circles);
  Fitted best;
  for (int k = plan.first_start; k < plan.first_start + plan.starts; ++k) {
    const std::uint64_t seed =
        k == 0 ? asked.seed : RandomStream(asked.seed, "starts").bits(std::uint64_t(k));
    const Eigen::VectorXd white = plan.warm.size() > 0 ? plan.warm
                                  : asked.start == FitStart::kZero
                                      ? Eigen::VectorXd::Zero(problem.prior.size()).eval()
                                      : draw_white(problem.prior.size(), seed);
    const std::optional<RayStart> near =
        by_rays ? approach_by_rays(of, plan, bench.met_within, problem, white) : std::nullopt;
    double of_this = near ? near->begun.mismatch : HUGE_VAL;
    const FitOptions how = fit_options(of, plan, bench.met_within, k, near || plan.warm.size() > 0, &of_this);
    FitResult result = calibrate(problem, near ? near->white : white, how);
    *lowest = std::min(*lowest, of_this);
    if (result.status == FitStatus::kCancelled && plan.on_stall == OnStall::kEnd && !of.context.stopped()) {
      result.status = FitStatus::kNotConverged;
      result.message = fmt::format(
          "ended after {} iterations, the last of which brought the largest mismatch no nearer than {:.3g} "
          "tolerances",
          result.iterations, of_this);
    }
    const bool met = result.status == FitStatus::kConverged &&
                     within_tolerance(problem, result, std::max(1.0, how.stop_at));
    if (!has_solution(best.fit) || (has_solution(result) && result.final_cost < best.fit.final_cost)) {
      best = {std::move(result), white, {}};
      if (near) best.begun = near->begun;
    }
    if (met) break;
  }
  return best;
}

// Largest |S - T| / tolerance; infinite where a statistic has no value, which is no match.
double worst_mismatch(const std::vector<Target>& aims, const Eigen::VectorXd& values) {
  double worst = 0;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const Target& aim = aims[std::size_t(k)];
    const double mismatch = std::abs(values[k] - aim.value) / aim.tolerance;
    worst = std::isnan(mismatch) ? kInfinity : std::max(worst, mismatch);
  }
  return worst;
}

// By the criterion the fit is stopped with, PSD bins included.
double worst_mismatch(const FitProblem& problem, const FitResult& fit) {
  double worst = worst_mismatch(problem.targets, fit.smooth_statistics);
  for (Eigen::Index b = 0; b < fit.spectrum.size(); ++b)
    worst = std::max(worst, std::abs(std::log(fit.spectrum[b] / problem.spectrum_target[b])) /
                                problem.spectrum_tolerance[b]);
  return worst;
}

// How far the fit's own rays are from fresh ones, and those from each other.
RayChoice ray_choice(const FitCase& of, const FitPlan& plan, const Attempt& attempt) {
  RayChoice choice;
  choice.automatic = plan.automatic_rays;
  choice.allowed = kRayShareOfMargin * of.task.equivalence.margin;
  choice.gap = choice.sampling_error = 0;
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  const Eigen::VectorXd fresh = judged.judged(attempt.first_seen),
                        error = judged.judged(attempt.fresh.standard_error);
  for (Eigen::Index k = 0; k < attempt.own.size(); ++k) {
    const double scale = aim_of(of.targets.fitted[std::size_t(k)]).scale;
    if (!(scale > 0)) continue;
    // What has no value on one of the two is no agreement.
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
  if (bench.model == FocusModel::kWaves)
    hold_closer(problem.targets.size() + std::size_t(spectrum.value.size()), prior.size(), &problem.guides);
  return problem;
}

// A fit may stay away from its targets because the grid itself errs by as much: light beyond the field of
// view folds back, and no surface undoes that. The same surface on the next grid tells. (The grid of a draw
// does not: the README's study starts on one that errs by 13 tolerances of its draw and passes.)
bool grid_is_in_the_way(const FitCase& of, const FitPlan& plan, const Attempt& attempt) {
  constexpr double kNoticeably = 0.8;
  if (attempt.met || plan.coarsening <= kLeastCoarsening) return false;
  const std::vector<Target> aims = aims_of(of.targets.fitted);
  const double own = worst_mismatch(aims, attempt.own);
  if (!(own > 1)) return false;
  const TermSet& terms = attempt.result.terms;
  Workbench next(of.task, FocusModel::kWaves, plan.pupil, grid_pitch(of, terms, plan.coarsening / kNextGrid),
                 terms, of.context.threads, of.ground.split);
  next.wide_circles = attempt.bench->wide_circles;
  next.single_precision = attempt.bench->single_precision;
  const Eigen::VectorXd values =
      next.exact(of.task, attempt.result.fit.coefficients, statistics_of(aims), of.context.threads, nullptr);
  return worst_mismatch(aims, values) < kNoticeably * own;
}

// Terms that cannot carry what they are asked to are as far off on any grid that has a pattern of them; the
// grid that judges says by how much. (12 % of a g of 22 by 35 Zernikes: 333 tolerances on the first, 315 on
// the next, at a minute each.)
bool far_on_any_grid(const Attempt& attempt) { return !attempt.met && attempt.mismatch > StallWatch::kFar; }

// Whether the grid that judges has every target within its tolerance as the fit's own has.
bool met_where_judged(const FitCase& of, const Attempt& attempt) {
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  return attempt.met && worst_mismatch(aims_of(of.targets.fitted),
                                       judged.judged(attempt.fresh.value).head(attempt.own.size())) <=
                            attempt.bench->met_within;
}

// A closer look may find that the surface it begins with has all it asks for: it ends there, and the verdict
// on it is known.
bool is_seen(const FitPlan& plan, const Attempt& attempt) {
  const Eigen::VectorXd& white = attempt.result.fit.white;
  return white.size() > 0 && white.size() == plan.seen.size() && white == plan.seen;
}

// Waves: first on a coarse grid, then, from where that ended, on finer ones until the grid that the light
// needs says the same of the surface. A set that was asked for and misses the margin between its targets, all
// of which it meets, gets another look with what lies between them held more closely: of the twenty seeds of
// fits/smooth-waves one does.
Attempt fit_on_fine_enough_grid(const FitCase& of, FitPlan plan, bool judge_always) {
  std::optional<Attempt> doubted;
  std::optional<RayApproach> begun;  // of the first: the others go on from it
  plan.coarsening = kFirstCoarsening;
  for (;;) {
    Attempt attempt = attempt_fit(of, plan);
    if (attempt.result.begun_by_rays) begun = attempt.result.begun_by_rays;
    attempt.result.begun_by_rays = begun;
    if (of.context.stopped() || is_seen(plan, attempt))
      return doubted ? std::move(*doubted) : std::move(attempt);
    // Phases that turn too far from cell to cell have no pattern on this grid. The perfect mirror has one on
    // any, if no derivative.
    const bool no_pattern =
        (attempt.result.fit.status == FitStatus::kDegenerate && of.task.fit.start != FitStart::kZero) ||
        attempt.result.fit.status == FitStatus::kFailed;
    const bool in_the_way = !no_pattern && grid_is_in_the_way(of, plan, attempt);
    if (!no_pattern) {  // the next grid goes on from here, and once
      plan.warm = attempt.result.fit.white;
      plan.starts = 1;
    }
    if (!(no_pattern || in_the_way) || plan.coarsening <= kLeastCoarsening) {
      if (judge_always || attempt.met) judge_on_fresh_rays(of, &attempt);
      if (attempt.fresh.rays == 0) return attempt;
      RayChoice& choice = attempt.result.ray_choice.emplace(ray_choice(of, plan, attempt));
      const double share = gap_share(attempt.bench->pitch / grid_pitch(of, attempt.result.terms, 1),
                                     attempt.judging_coarsening);
      choice.allowed = share * of.task.equivalence.margin;
      const bool of_its_cells =
          explain_cells(attempt.result.rays, share, met_where_judged(of, attempt), &choice);
      const bool equivalent = attempt.result.verdict == Verdict::kEquivalent;
      const bool fine = of_its_cells || plan.coarsening <= kLeastCoarsening || far_on_any_grid(attempt);
      if (fine && (doubted || equivalent || !judge_always || !attempt.met))
        return doubted && !equivalent ? std::move(*doubted) : std::move(attempt);
      if (fine) {
        plan.guides_within = kGuidesInDoubt;
        plan.seen = attempt.result.fit.white;
        doubted = std::move(attempt);
        continue;
      }
    }
    plan.coarsening /= kNextGrid;
  }
}

// Starts are judged by the verdict, which by waves has no luck in it: what meets the fitted targets may miss
// between them. Returns the first that is equivalent, else the nearest.
Attempt fit_until_equivalent(const FitCase& of, const FitPlan& plan, bool judge_always) {
  std::optional<Attempt> nearest;
  for (int k = 0; k < plan.starts; ++k) {
    FitPlan one = plan;
    one.starts = 1;
    one.first_start = plan.first_start + k;
    Attempt attempt = fit_on_fine_enough_grid(of, std::move(one), judge_always);
    if (!nearest || is_equivalent(attempt) || nearer(attempt, *nearest)) nearest = std::move(attempt);
    if (is_equivalent(*nearest) || of.context.stopped()) break;
  }
  nearest->result.chosen.starts = plan.starts;
  return std::move(*nearest);
}

}  // namespace

double internal::grid_pitch(const FitCase& of, const TermSet& terms, double coarsening) {
  if (of.ground.use.model != FocusModel::kWaves) return 0;
  return wave_pitch(of.task, terms, all_targets(of.targets), of.ground.split.get(), coarsening);
}

bool is_equivalent(const Attempt& attempt) {
  return attempt.fresh.rays > 0 && attempt.met && attempt.result.verdict == Verdict::kEquivalent;
}

double distance_to_margin(const Attempt& attempt) {
  double worst = attempt.mismatch / attempt.met_within;
  for (const EquivalenceMetric& metric : attempt.result.metrics) {
    const double distance = std::abs(metric.difference) / metric.margin;
    worst = std::isnan(distance) ? kInfinity : std::max(worst, distance);
  }
  return worst;
}

bool nearer(const Attempt& a, const Attempt& b) {
  if (a.met != b.met) return a.met;
  return a.met ? distance_to_margin(a) < distance_to_margin(b) : a.mismatch < b.mismatch;
}

void describe_scene(const FitCase& of, double captured, FitOutcome* result) {
  const SceneFacts facts = scene_facts(of.ground, of.targets.theory);
  result->has_roughness = of.ground.psd.has_value();
  result->scene = facts.numbers;
  result->theory = facts.theory;
  result->model = facts.model;
  result->needed = facts.needed;
  result->light_decides = of.ground.use.light_decides;
  result->model_reason = facts.reason;
  result->errors = facts.errors;
  result->targets = of.targets.fitted;
  result->shares = of.ground.shares;
  const Warnings scene = scene_warnings(of.task, of.ground, result->terms, captured);
  for (const Warnings* told : {&scene, &of.targets.warnings})
    result->warnings.insert(result->warnings.end(), told->begin(), told->end());
}

FitOutcome outcome_of(const FitCase& of, const FitPlan& plan) {
  FitOutcome result;
  result.radius = of.ground.radius;
  result.terms = plan.terms->terms;
  result.chosen = {plan.terms->asked, rays_of(plan.pupil), plan.starts};
  result.chosen.terms.band.rule = BandRule::kAll;
  if (of.ground.split) result.chosen.terms.band = {BandRule::kCut, of.ground.split->cut()};
  result.confidence = of.task.equivalence.confidence;
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
  return {task.mirror,       pupil,          surface, model,   task.wavelength, &task.aperture,
          task.trace.centre, kAliasedInAFit, nullptr, scatter, wide_circles,    single_precision};
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
                                                grid_pitch(of, result.terms, plan.coarsening), result.terms,
                                                threads, of.ground.split);
  made->wide_circles = wide_circles(of.task, of.ground, of.targets, kWideShareOfFit);
  made->single_precision = in_single_precision(of.ground.use.model, of.targets, made->pupil.size());
  made->met_within =
      met_within(of.task, of.ground.use.model, of.targets, made->pupil.size(), made->wide_circles);
  attempt.met_within = made->met_within;
  attempt.bench = made;
  const Workbench& bench = *attempt.bench;
  result.rays = bench.pupil.size();

  const SpectrumTarget spectrum = make_spectrum_target(of.task, of.ground, result.terms, prior, threads);
  const FitProblem problem = problem_of(of, bench, prior, spectrum);
  double lowest = HUGE_VAL;  // what is known of a fit that was given up
  Fitted best = fit_from_starts(of, plan, bench, problem, &lowest);
  result.fit = std::move(best.fit);
  result.begun_by_rays = best.begun;
  attempt.mismatch = has_solution(result.fit) ? worst_mismatch(problem, result.fit) : lowest;
  attempt.met =
      result.fit.status == FitStatus::kConverged && within_tolerance(problem, result.fit, bench.met_within);
  const JudgedSet fitted(of.targets.fitted, {});
  result.start =
      fitted.shown(bench.exact(of.task, prior.colour(best.draw), fitted.statistics(), threads, nullptr));
  for (Eigen::Index b = 0; b < result.fit.spectrum.size(); ++b)
    result.spectrum.push_back({spectrum.low[b], spectrum.high[b], spectrum.value[b], result.fit.spectrum[b],
                               spectrum.tolerance[b]});
  const Eigen::VectorXd own =
      bench.exact(of.task, result.fit.coefficients, fitted.statistics(), threads, &attempt.own_warnings);
  result.fitted = fitted.shown(own);
  attempt.own = fitted.judged(own);
  result.posterior_std = shown_std(of.targets.fitted, result.fit.statistic_std);
  return attempt;
}

Attempt fit_on_enough_rays(const FitCase& of, FitPlan plan, bool judge_always) {
  if (of.ground.use.model == FocusModel::kWaves) return fit_until_equivalent(of, plan, judge_always);
  if (plan.automatic_rays) plan.pupil.rays = first_rays(plan.terms->terms.size());
  std::optional<Attempt> judged;  // on fewer rays
  for (;;) {
    Attempt attempt = attempt_fit(of, plan);
    if (of.context.stopped()) return judged ? std::move(*judged) : std::move(attempt);
    if (judge_always || attempt.met) judge_on_fresh_rays(of, &attempt);
    if (attempt.fresh.rays == 0) return attempt;
    RayChoice& choice = attempt.result.ray_choice.emplace(ray_choice(of, plan, attempt));
    if (!plan.automatic_rays || explain_rays(rays_of(plan.pupil), attempt.result.verdict, &choice))
      return attempt;
    plan.pupil.rays = more_rays(rays_of(plan.pupil));
    judged = std::move(attempt);
  }
}

}  // namespace aberfit
