#include "aberfit/method/verify.h"

#include <cassert>
#include <cmath>

#include "aberfit/focus/counted_ring_width.h"
#include "aberfit/method/plan.h"
#include "aberfit/theory/ray_perturbation.h"
#include "task_surface.h"
#include "verify_branches.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kIdealRing = 10e-6;  // the ring the paper lays around the ideal focus

// EE at focus, ring widths, angles and spot: what both branches can be asked for.
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

void add_scene_quantities(const SceneNumbers& scene, Quantities* quantities) {
  Quantities& q = *quantities;
  q["scene.rms_height_m"] = scene.rms_height;
  q["scene.rms_slope_per_axis"] = scene.rms_slope_per_axis;
  q["scene.rms_slope_total"] = scene.rms_slope_per_axis * std::sqrt(2.0);
  q["scene.correlation_length_m"] = scene.correlation_length;
  q["scene.n_eff"] = scene.n_eff;
  q["scene.g"] = scene.g;
  q["scene.kappa"] = scene.kappa;
  q["scene.tis"] = scene.tis;
  q["scene.paper_ratio_r"] = scene.paper_ratio_r;
}

void add_ideal_quantities(const RayBundle& nominal, Quantities* quantities) {
  const Eigen::ArrayXd no_height = Eigen::ArrayXd::Zero(nominal.size());
  (*quantities)["ideal.ring_fwhm_m"] =
      evaluate_exact({nominal, nominal, no_height, Centre::kNominal}, {RingFwhm{0.9, kIdealRing}}, 1)[0];
  (*quantities)["ideal.ring_fwhm_counted_m"] = counted_ring_width(nominal, kIdealRing, 1e-4, 2e-2);
  (*quantities)["ideal.ee90_radius_m"] =
      evaluate_exact({nominal, nominal, no_height, Centre::kNominal}, {EncircledEnergyRadius{}}, 1)[0];
}

Branch harvey_shack_branch(const Task& task, const Groundwork& ground, const PupilSample& pupil,
                           const RayBundle& nominal, const std::vector<Statistic>& statistics, int threads) {
  Branch branch;
  const Eigen::ArrayXd no_height = Eigen::ArrayXd::Zero(pupil.size());
  branch.rays = trace_perturbed(task.mirror, pupil, ground.numbers.rms_slope_per_axis, task.target.convention,
                                task.trace.pupil.seed);
  branch.statistics =
      evaluate_exact({branch.rays, nominal, no_height, task.trace.centre}, statistics, threads);
  return branch;
}

Branch terms_branch(const Task& task, const PupilSample& pupil, const RayBundle& nominal,
                    const GivenSurface& surface, const std::vector<Statistic>& statistics, int threads) {
  Branch branch;
  branch.field = surface_field(task, pupil, surface, threads);
  branch.rays = trace(task.mirror, pupil, branch.field);
  branch.statistics =
      evaluate_exact({branch.rays, nominal, branch.field.height, task.trace.centre}, statistics, threads);
  return branch;
}

// Rays by analytic normals, whatever the task's: the scatter between draws is no matter of normals.
Realisation verify_realisation(const Task& task, const Groundwork& ground, const PupilSample& pupil,
                               const TermSet& terms, int threads) {
  const SurfaceOperator surface(terms, pupil, {threads, {}, {}});
  const CoefficientPrior prior = plan_terms(task, ground, task.terms).prior;
  return realisation_of(
      task, ground,
      {task.mirror, pupil, surface, FocusModel::kRays, task.wavelength, &task.aperture, task.trace.centre},
      prior, threads);
}

// Both branches are rays. Where these are the wrong model, agreement of the two decides nothing.
Verdict verify_verdict(const Groundwork& ground, const std::vector<EquivalenceMetric>& metrics) {
  const Verdict verdict = overall(metrics);
  const bool rays_decide = ground.use.choice->model == FocusModel::kRays;
  return rays_decide || verdict != Verdict::kEquivalent ? verdict : Verdict::kUndecided;
}

// Theory in closed form, and the two branches tested against each other.
void compare(const Task& task, const Groundwork& ground, const std::vector<Statistic>& statistics,
             const Branch& harvey_shack, const Branch& terms, VerifyReport* report) {
  const double sampling =
      0.51e-2 * std::sqrt(15000.0 / double(report->rays));  // PHYSICS 2, ee90 of random rays
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto at = Eigen::Index(k);
    const std::string name = statistic_name(statistics[k]);
    // The closed form has the part of the mirror that is of revolution: nothing to show for another one.
    report->theory.push_back(is_rotationally_symmetric(task.mirror) ? (*ground.theory)(statistics[k])
                                                                    : std::nan(""));
    report->quantities["theory." + name] = report->theory.back();
    report->quantities["harvey_shack." + name] = harvey_shack.statistics[at];
    report->quantities["aberration_terms." + name] = terms.statistics[at];
    report->metrics.push_back(tost(name, false, harvey_shack.statistics[at],
                                   sampling * harvey_shack.statistics[at], terms.statistics[at],
                                   std::hypot(sampling, report->spread) * terms.statistics[at],
                                   task.equivalence.margin, task.equivalence.confidence));
  }
  report->verdict = verify_verdict(ground, report->metrics);
}

Warnings verify_warnings(const Task& task, const Groundwork& ground) {
  Warnings warnings;
  if (ground.use.choice->model != FocusModel::kRays)
    warnings.push_back({"rays-not-valid", ground.use.reason + " Both branches here are rays: their agreement "
                                                              "is no verdict on the focus."});
  if (task.trace.central_difference_step)
    warnings.push_back(
        {"central-difference", "normals by central differences: a hidden low-pass filter (PHYSICS 8)"});
  return warnings;
}

}  // namespace

VerifyReport verify(const Task& task, const VerifyAside& aside, const std::optional<GivenSurface>& given,
                    int threads) {
  assert(task.psd);
  const Groundwork ground = lay_groundwork(task);
  const PupilSample pupil = make_pupil(task.aperture, task.trace.pupil);
  const RayBundle nominal = trace_nominal(task.mirror, pupil);
  const std::vector<Statistic> statistics = branch_statistics(ground);
  const Branch harvey_shack = harvey_shack_branch(task, ground, pupil, nominal, statistics, threads);
  const GivenSurface surface = surface_of(task, ground, given);
  const Branch terms = terms_branch(task, pupil, nominal, surface, statistics, threads);

  VerifyReport report;
  report.convention = task.target.convention;
  report.rays = pupil.size();
  report.margin = task.equivalence.margin;
  report.scene = scene_facts(ground, to_string(Theory::kRays));
  report.scene.model = to_string(FocusModel::kRays);
  // The scatter is the larger of what the law says and, near the margin, what draws show.
  report.scene.realisation = given ? Realisation{ground.numbers.realisation_spread, std::nan(""), 0}
                                   : verify_realisation(task, ground, pupil, surface.terms, threads);
  report.spread = given ? 0.0 : report.scene.realisation->spread();
  compare(task, ground, statistics, harvey_shack, terms, &report);

  Quantities& quantities = report.quantities;
  add_scene_quantities(ground.numbers, &quantities);
  add_ideal_quantities(nominal, &quantities);
  add_paper_quantities("harvey_shack", task, ground, pupil, nominal, harvey_shack, &quantities);
  add_paper_quantities("aberration_terms", task, ground, pupil, nominal, terms, &quantities);
  if (aside.published_phase)
    add_published_phase(task, *aside.published_phase, pupil, nominal, threads, &quantities);
  if (aside.independent_terms) add_independent_terms(task, *aside.independent_terms, threads, &quantities);
  report.warnings = verify_warnings(task, ground);
  return report;
}

}  // namespace aberfit
