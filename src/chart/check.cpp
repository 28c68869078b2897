#include "aberfit/chart/check.h"

#include <chrono>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/memory.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fit_as_asked.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/spectrum_target.h"

namespace aberfit {
namespace {

std::optional<CheckedCells> checked_cells(const Task& task, const Groundwork& ground, const TermSet& terms,
                                          const TargetSets& targets) {
  if (ground.use.model != FocusModel::kWaves) return std::nullopt;
  const std::vector<Target> all = all_targets(targets);
  try {
    const double across = 2 * ground.radius;
    return CheckedCells{across / wave_pitch(task, terms, all, ground.split.get(), law::kFirstCoarsening),
                        across / wave_pitch(task, terms, all, ground.split.get())};
  } catch (const ComputationError&) {
    return std::nullopt;
  }
}

class FirstIteration {
 public:
  FirstIteration(const FitCase& of, const TermPlan& plan, double coarsening)
      : of_(of),
        plan_(plan),
        bench_(of.task, of.ground.use.model, rays(), pitch(coarsening), plan.terms, of.context.threads,
               of.ground.split),
        spectrum_(make_spectrum_target(of.task, of.ground, plan.terms, plan.prior, of.context.threads)) {
    bench_.single_precision = in_single_precision(of.ground.use.model, of.targets, bench_.pupil.size());
  }

  Eigen::Index points() const { return bench_.pupil.size(); }
  Eigen::Index residuals() const {
    return Eigen::Index(of_.targets.fitted.size() + of_.targets.guides.size()) + spectrum_.value.size();
  }
  /// Memory of the gradients of all residuals over the points and over the terms.
  double bytes() const { return 8.0 * double(residuals()) * double(points() + plan_.terms.size()); }

  /// Judges the random surface on the points of the first verdict.
  void judge(CheckedCost* cost) const {
    const FocusModel model = of_.ground.use.model;
    const double fresh_pitch =
        model == FocusModel::kWaves
            ? wave_pitch(of_.task, plan_.terms, all_targets(of_.targets), of_.ground.split.get())
            : 0;
    // An iteration on as many points would take longer than the judgement.
    const double more = fresh_pitch > 0 ? std::pow(bench_.pitch / fresh_pitch, 2) : 4;
    if (more * *cost->iteration_seconds > kLong) return;
    const FreshPupil pupil{model,
                           4 * std::int64_t(points()),
                           of_.task.trace.pupil.seed,
                           fresh_pitch,
                           in_single_precision(model, of_.targets, cells_of(of_.task, fresh_pitch)),
                           false};
    of_.context.say("check: the verdict");
    const auto begin = std::chrono::steady_clock::now();
    statistics_with_error(
        lit_mirror(of_.task, of_.ground.split), pupil, plan_.terms, plan_.prior.colour(draw()),
        JudgedSet(of_.targets.fitted, of_.targets.held_out).statistics(), of_.context.threads, nullptr);
    cost->verdict_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  FitStatus run(CheckedCost* cost) const {
    FitProblem problem{bench_.focus(of_.task), plan_.prior, aims_of(of_.targets.fitted),
                       aims_of(of_.targets.guides), of_.ground.focal_sigma};
    problem.spectrum = spectrum_.spectrum.get();
    problem.spectrum_target = spectrum_.value;
    problem.spectrum_tolerance = spectrum_.tolerance;
    FitOptions how;
    how.prior = of_.task.fit.prior;
    how.bound = of_.task.fit.bound_sigmas;
    how.threads = of_.context.threads;
    how.stop_at = 0;  // makes at least one iteration
    double begin = 0;
    how.progress = [&](const FitProgress& p) {
      if (p.iteration == 0) {
        begin = p.seconds;
        cost->at_least = begin > kLong;
        if (cost->at_least) cost->iteration_seconds = begin;
        return !cost->at_least && !of_.context.stopped();
      }
      cost->iteration_seconds = (p.seconds - begin) / p.iteration;
      // A rejected step takes only part of the time of an accepted one; quick steps are therefore averaged.
      return p.iteration < 5 && p.seconds < 1 && !of_.context.stopped();
    };
    return calibrate(problem, draw(), how).status;
  }

 private:
  // [s] Longer parts are left out, because a check should take seconds.
  static constexpr double kLong = 10;

  Eigen::VectorXd draw() const { return draw_white(plan_.prior.size(), of_.task.fit.seed); }
  PupilOptions rays() const {
    PupilOptions pupil = of_.task.trace.pupil;
    if (!pupil.rays) pupil.rays = first_rays(plan_.terms.size());
    return pupil;
  }
  double pitch(double coarsening) const {
    return of_.ground.use.model == FocusModel::kWaves
               ? wave_pitch(of_.task, plan_.terms, all_targets(of_.targets), of_.ground.split.get(),
                            coarsening)
               : 0;
  }

  const FitCase& of_;
  const TermPlan& plan_;
  Workbench bench_;
  SpectrumTarget spectrum_;
};

// Cost on the first grid on which the random surface has a diffraction pattern, as in `fit`.
CheckedCost checked_cost(const FitCase& of, const TermsSpec& asked) {
  CheckedCost cost;
  if (of.ground.all_scatters()) {
    cost.obstacle = "no frequency needs a term; random mirrors are judged and nothing is iterated";
    return cost;
  }
  try {
    const TermPlan plan = plan_terms(of.task, of.ground, asked);
    for (double coarsening = law::kFirstCoarsening; !cost.iteration_seconds; coarsening *= std::sqrt(0.5)) {
      const FirstIteration first(of, plan, coarsening);
      cost.points = first.points();
      cost.residuals = first.residuals();
      cost.bytes = first.bytes();
      if (cost.bytes > machine_memory()) {
        cost.obstacle = "one iteration needs more memory than the machine has";
        return cost;
      }
      of.context.stop_if_asked();
      of.context.say("check: one iteration");
      const FitStatus status = first.run(&cost);
      of.context.stop_if_asked();
      if (cost.iteration_seconds && !cost.at_least) first.judge(&cost);
      if (!cost.iteration_seconds && (of.ground.use.model == FocusModel::kRays || coarsening < 1)) {
        cost.obstacle = status == FitStatus::kDegenerate
                            ? "a statistic of the random start has no value or derivative"
                            : "the first iteration failed";
        return cost;
      }
    }
    cost.bytes = peak_memory();
  } catch (const ComputationError& error) {  // no grid is fine enough; `fit` reports the same
    cost.obstacle = error.what();
  }
  return cost;
}

}  // namespace

TermsSpec first_set(const Task& task, const Groundwork& ground) {
  if (!task.terms.automatic() || !ground.term_psd || ground.all_scatters()) return task.terms;
  return terms_by_law(task, ground);
}

CheckReport make_check(const Task& task, const RunContext& context, bool measure) {
  const auto [ground, targets] = lay_out(task, context.threads);
  const TermsSpec asked = first_set(task, ground);
  double captured = 0;
  const TermSet terms = make_terms(task, ground, asked, &captured);
  CheckReport report;
  report.warnings = scene_warnings(task, ground, terms, captured);
  report.warnings.insert(report.warnings.end(), targets.warnings.begin(), targets.warnings.end());
  report.mirror = characterise(task.mirror, task.aperture);
  report.focal_sigma = ground.focal_sigma;
  report.theory = targets.theory;
  report.model = ground.use.model;
  report.reason = ground.use.reason;
  if (ground.psd) {
    report.scene = scene_facts(ground, targets.theory);
    report.scene->mean_light = specified_light(ground);
    report.scene->spread = mirror_spread(task, ground, targets, context.threads);
    report.too_simple =
        ground.use.choice->model != FocusModel::kRays && !ground.use.in_light(targets_are_given(task));
    report.light_decides = ground.use.light_decides;
  }
  report.terms = {terms.size(), captured, task.terms.automatic() && ground.psd && !ground.all_scatters(),
                  terms.zernike.empty() ? 0 : terms.zernike.back().n,
                  terms.of_a_segment() > 0 ? terms.segments->all().size() : 0};
  report.statistics = {targets.fitted.size(), targets.guides.size(), targets.held_out.size()};
  report.theory_error = ground.use.theory_error;
  report.cells = checked_cells(task, ground, terms, targets);
  report.fitted = targets.fitted;
  report.held_out = targets.held_out;
  report.automatic_rays = !task.trace.pupil.rays;
  report.rays = task.trace.pupil.rays.value_or(first_rays(terms.size()));
  report.starts = task.fit.starts;
  report.threads = context.threads;
  report.shares = ground.shares;
  if (measure) report.cost = checked_cost({task, ground, targets, context}, asked);
  return report;
}

MapCheckReport make_map_check(const HeightMap& map, const TermSet& terms) {
  MapCheckReport report;
  report.columns = map.columns();
  report.rows = map.rows();
  report.valid = valid_count(map);
  report.pitch_x = map.pitch_x;
  report.pitch_y = map.pitch_y;
  report.terms = terms.size();
  return report;
}

}  // namespace aberfit
