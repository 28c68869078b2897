#include "aberfit/method/verify.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/plan.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/theory/ray_perturbation.h"
#include "task_surface.h"
#include "verify_ensemble.h"

namespace aberfit {
using namespace internal;

namespace {

// Statistics that both branches have: EE at focus, ring widths, angles and spot.
std::vector<Statistic> branch_statistics(const Groundwork& ground) {
  std::vector<Statistic> statistics;
  for (const double fraction : {0.2, 0.5, 0.8, 0.9, 0.95})
    statistics.push_back(EncircledEnergyRadius{fraction, 0});
  for (const double units : {-2.0, 2.0})
    statistics.push_back(EncircledEnergyRadius{0.9, 1e-6 * std::round(1e6 * units * ground.plane_unit())});
  statistics.push_back(RingFwhm{});
  statistics.push_back(RingFwhm{0.5, {}});
  statistics.push_back(ScatterRms{});
  statistics.push_back(ScatterMean{});
  statistics.push_back(SpotFwhm{0.1 * ground.focal_sigma});
  statistics.push_back(RmsRadius{});
  return statistics;
}

// Compares a given surface on the pupil of the task; the uncertainty is the sampling of both branches.
void compare_given(const Task& task, const std::vector<Statistic>& statistics, const VerifyRays& shown,
                   int threads, VerifyReport* report) {
  const auto values_of = [&](const RayBundle& rays) {
    return evaluate_exact({rays, shown.nominal, shown.field.height, task.trace.centre}, statistics, threads);
  };
  const Eigen::VectorXd harvey_shack = values_of(shown.harvey_shack), terms = values_of(shown.terms);
  const double sampling =
      0.51e-2 * std::sqrt(15000.0 / double(report->rays));  // PHYSICS 2, ee90 of random rays
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto at = Eigen::Index(k);
    report->metrics.push_back(tost(statistic_name(statistics[k]), false, harvey_shack[at],
                                   sampling * harvey_shack[at], terms[at], sampling * terms[at],
                                   task.equivalence.margin, task.equivalence.confidence));
  }
}

// Compares the mean irradiance of the realisations with that of as many perturbed rays.
void compare_means(const Ensemble& ensemble, const Groundwork& ground,
                   const std::vector<Statistic>& statistics, VerifyReport* report) {
  const Task& task = ensemble.task;
  const EnsembleMean terms = ensemble_by_rays(ensemble, statistics);
  const EnsembleMean rays = ensemble_of_perturbed_rays(task, ground.numbers.rms_slope_per_axis,
                                                       ensemble.draws, statistics, ensemble.context.threads);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto at = Eigen::Index(k);
    report->metrics.push_back(tost(statistic_name(statistics[k]), false, rays.value[at],
                                   rays.standard_error[at], terms.value[at], terms.standard_error[at],
                                   task.equivalence.margin, task.equivalence.confidence,
                                   {kGroupFreedom, kGroupFreedom}));
  }
}

// Rays decide where the task names their theory, or a convention that only rays have.
bool asks_for_rays(const Task& task) {
  return task.target.convention == Convention::kPaper || task.target.theory == Theory::kGeometric ||
         task.target.theory == Theory::kRays;
}

void decide(const Task& task, const Groundwork& ground, VerifyReport* report) {
  report->rays_verdict = overall(report->metrics);
  report->rays_decide = asks_for_rays(task) || !report->light_obstacle.empty();
  report->verdict = report->rays_decide ? report->rays_verdict : report->light_verdict;
  // Without wave optics, agreement by rays proves nothing where they are the wrong model.
  if (report->rays_decide && !asks_for_rays(task) && ground.use.choice->model != FocusModel::kRays &&
      report->verdict == Verdict::kEquivalent)
    report->verdict = Verdict::kUndecided;
}

// Spread of single mirrors in the compared statistics, by wave optics.
MirrorSpread spread_of_branches(const Task& task, const Groundwork& ground,
                                const std::vector<Statistic>& statistics, int threads) {
  if (!ground.use.obstacle.empty()) return {};
  try {
    const GeneralisedHarveyShack light(*ground.prior_psd, task.mirror, task.aperture, task.wavelength);
    TargetSets targets;
    Eigen::VectorXd slopes;
    const Eigen::VectorXd values = light.predict(statistics, threads, &slopes);
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      Target target{statistics[k], values[Eigen::Index(k)]};
      if (std::holds_alternative<EncircledEnergyRadius>(target.statistic))
        target.curve_slope = slopes[Eigen::Index(k)];
      if (std::isfinite(target.value)) targets.fitted.push_back(target);
    }
    return mirror_spread(task, ground, targets, threads);
  } catch (const ComputationError&) {  // compare_in_light gives the reason
    return {};
  }
}

// Spread of the worst statistic; without wave optics of the RMS slope, whose square is a mean of N_eff.
double spread_in_margins(const SceneFacts& scene, const EquivalenceSpec& test) {
  if (const StatisticSpread* worst = scene.spread.worst()) return worst->tolerances;
  return scene.numbers.n_eff > 0 ? std::sqrt(0.5 / scene.numbers.n_eff) / test.margin : kNaN;
}

// Surfaces whose terms end below the band represent another roughness, however large the ensemble is.
std::optional<Warning> warn_of_missing_terms(const Groundwork& ground, const TermPlan& plan) {
  if (plan.terms.zernike.empty() || !plan.terms.fourier.empty()) return std::nullopt;
  const int order = plan.terms.zernike.back().n,
            needed = order_to_carry(ground.radius, band_end(*ground.term_psd));
  if (order + 1 >= needed) return std::nullopt;  // `needed` is rounded up
  const double end = order / (law::kOrderBeyondCut * kTwoPi * ground.radius);
  const double slopes = radial_moment(*ground.term_psd, 2, end) / radial_moment(*ground.term_psd, 2);
  return Warning{
      "truncated-terms",
      fmt::format("the compared band needs Zernikes to n = {}, but the terms end at {}. Beyond {} they leave "
                  "out {} of the slope variance, which more realisations do not cure; {}",
                  needed, order, format_quantity(end, Dimension::kSpatialFrequency), format_percent(slopes),
                  needed <= law::kLargestOrder ? "leave `n_max` out, and the terms carry the whole band"
                                               : "take a larger `n_max` (which takes minutes), a lower "
                                                 "f_max, or `fit`, where the rest is scatter")};
}

Warnings verify_warnings(const Groundwork& ground, const TermPlan& plan, const VerifyReport& report) {
  Warnings warnings;
  const std::optional<Warning> missing = warn_of_missing_terms(ground, plan);
  if (missing) warnings.push_back(*missing);
  if (report.rays_decide && ground.use.choice->model != FocusModel::kRays)
    warnings.push_back({"rays-not-valid",
                        ground.use.reason +
                            " The verdict here is by rays; it says nothing about the focus by wave optics."});
  if (!report.light_obstacle.empty())
    warnings.push_back({"no-light", "wave optics is not shown: " + report.light_obstacle});
  if (report.draws > 0 && !missing && report.verdict == Verdict::kUndecided)
    warnings.push_back({"few-draws", fmt::format("the means of {} realisations do not decide at this margin; "
                                                 "use more (`draws` in `verify`) or a wider margin",
                                                 report.draws)});
  return warnings;
}

}  // namespace

Deflections deflections_of(const RayBundle& rays, const RayBundle& nominal) {
  const auto along = [](const RayBundle& r) { return (1 + r.tx.square() + r.ty.square()).rsqrt().eval(); };
  const Eigen::ArrayXd c = along(rays), c0 = along(nominal);
  Deflections d;
  d.x = rays.tx * c - nominal.tx * c0;
  d.y = rays.ty * c - nominal.ty * c0;
  d.z = c - c0;
  d.magnitude = (d.x.square() + d.y.square() + d.z.square()).sqrt();
  d.weight = rays.weight / rays.weight.sum();
  const auto mean = [&](const Eigen::ArrayXd& v) { return (d.weight * v).sum(); };
  d.mean_x = mean(d.x), d.mean_y = mean(d.y), d.mean_z = mean(d.z), d.mean = mean(d.magnitude);
  const auto rms = [&](const Eigen::ArrayXd& v) { return std::sqrt(mean(v.square())); };
  d.rms_x = rms(d.x), d.rms_y = rms(d.y), d.rms_z = rms(d.z), d.rms = rms(d.magnitude);
  return d;
}

VerifyReport verify(const Task& task, std::optional<int> draws, const std::optional<GivenSurface>& given,
                    const RunContext& context) {
  assert(task.psd);
  const int threads = context.threads;
  const Groundwork ground = lay_groundwork(task);
  const PupilSample pupil = make_pupil(task.aperture, task.trace.pupil);
  const RayBundle nominal = trace_nominal(task.mirror, pupil);
  const std::vector<Statistic> statistics = branch_statistics(ground);
  const TermPlan plan = given ? TermPlan{} : plan_terms(task, ground, task.terms);
  const GivenSurface surface =
      given ? *given
            : GivenSurface{plan.terms, plan.prior.colour(draw_white(plan.terms.size(), task.fit.seed))};
  SurfaceField field = surface_field(task, pupil, surface, threads);
  RayBundle terms = trace(task.mirror, pupil, field);
  RayBundle harvey_shack = trace_perturbed(task.mirror, pupil, ground.numbers.rms_slope_per_axis,
                                           task.target.convention, task.trace.pupil.seed);

  VerifyReport report;
  report.shown = std::make_shared<VerifyRays>(
      VerifyRays{pupil, nominal, std::move(harvey_shack), std::move(terms), std::move(field), surface});
  report.convention = task.target.convention;
  report.rays = pupil.size();
  report.margin = task.equivalence.margin;
  report.scene = scene_facts(ground, to_string(Theory::kRays));
  report.scene.model = to_string(FocusModel::kRays);
  report.scene.spread = spread_of_branches(task, ground, statistics, threads);
  // The closed form covers rotationally symmetric mirrors only; others have no value to show.
  for (const Statistic& statistic : statistics)
    report.theory.push_back(is_rotationally_symmetric(task.mirror) ? (*ground.theory)(statistic)
                                                                   : std::nan(""));
  const int law = ensemble_draws(spread_in_margins(report.scene, task.equivalence));
  const int asked = (draws.value_or(law) + law::kGroups - 1) / law::kGroups * law::kGroups;
  report.draws = given ? 0 : asked;
  const Ensemble ensemble{task, surface.terms, plan.prior, report.draws, context};
  if (given)
    compare_given(task, statistics, *report.shown, threads, &report);
  else
    compare_means(ensemble, ground, statistics, &report);
  compare_in_light(ensemble, ground, given, statistics, &report);
  decide(task, ground, &report);

  report.warnings = verify_warnings(ground, plan, report);
  if (const auto differences = central_difference_warning(task, pupil, surface, report.shown->field, threads))
    report.warnings.push_back(*differences);
  return report;
}

}  // namespace aberfit
