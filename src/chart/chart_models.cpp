#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "aberfit/chart/check.h"
#include "aberfit/core/errors.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "chart_bench.h"

namespace aberfit::internal {
namespace {

// The surface's statistics on a grid for waves.
Eigen::VectorXd by_waves(const Task& task, const Groundwork& ground, const TermSet& terms,
                         const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics,
                         double pitch, int threads) {
  return Workbench(task, FocusModel::kWaves, {}, pitch, terms, threads, ground.split)
      .exact(task, coefficients, statistics, threads, nullptr);
}

std::string why_not_in_light(const ChartBench& bench) {
  return bench.ground.use.obstacle.empty() ? ""
                                           : "Wave optics does not apply: " + bench.ground.use.obstacle + ".";
}

std::string why_no_surface(const ChartBench& bench) {
  if (!bench.ground.psd) return "No roughness is given, so there is no rough surface to compare.";
  return bench.ground.all_scatters() ? "No frequency needs a term, so there is no surface to compare."
                                     : why_not_in_light(bench);
}

// |energy fraction - reference| / max(r dE/dr, 0.35) of encircled energies (PHYSICS 7).
std::vector<double> light_errors(const Eigen::VectorXd& values, const Eigen::VectorXd& reference,
                                 const std::vector<Target>& aims) {
  std::vector<double> errors;
  for (Eigen::Index k = 0; k < values.size(); ++k)
    errors.push_back(std::abs(values[k] - reference[k]) / aims[std::size_t(k)].relative_to());
  return errors;
}

}  // namespace

ChartFamily chart_theories(const ChartBench& bench, double seconds) {
  ChartFamily family = family_of("theories", "Theories of the mean spot",
                                 "largest wave-optics error of the encircled energies in the focus",
                                 "the curve in the focal plane", bench.third_of_margin());
  const Task& task = bench.task;
  family.skipped = bench.ground.psd ? why_not_in_light(bench) : "No roughness is given.";
  if (!family.skipped.empty()) return family;
  bench.say("chart: theories");
  const RadialPsd& psd = *bench.ground.psd;
  const MeanSpot truth = GeneralisedHarveyShack(psd, task.mirror, task.aperture, task.wavelength).at_plane(0);
  // Radii of these fractions, and the scales of their errors.
  const std::vector<double> fractions = {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95};
  std::vector<double> radii, scales;
  for (const double fraction : fractions) {
    radii.push_back(truth.encircled_energy_radius(fraction));
    scales.push_back(std::max(radii.back() * truth.encircled_energy_slope(radii.back()), kFlattestCurve));
  }
  // theory: makes the theory anew and returns its curve.
  const auto add = [&](const char* method, bool is_default, const auto& theory) {
    double worst = 0;
    const ChartTime time = measure_time(0.25 * seconds, [&] {
      const auto curve = theory();
      worst = 0;
      for (std::size_t k = 0; k < radii.size(); ++k)
        worst = std::max(worst, std::abs(curve(radii[k]) - fractions[k]) / scales[k]);
    });
    ChartRow row = row_of(method, "", std::nan(""));
    set_errors({worst}, "aperture-exact generalised Harvey-Shack", 0, &row);
    row.is_default = is_default;
    set_time(time, &row);
    family.rows.push_back(row);
  };
  const auto waves = [&] {
    const GeneralisedHarveyShack theory(psd, task.mirror, task.aperture, task.wavelength);
    return [spot = theory.at_plane(0)](double r) { return spot.encircled_energy(r); };
  };
  const bool light = bench.ground.use.theory == Theory::kGhs;
  add("aperture-exact", light, waves);
  // The aperture-exact theory has the error of the scalar theory of small angles, not zero.
  const TheoryError& own = *bench.ground.use.theory_error;
  set_errors({std::max(own.small_angle, own.beyond_ten_degrees)}, "its small-angle error", 0,
             &family.rows.back());
  const SceneNumbers& numbers = bench.ground.numbers;
  if (is_rotationally_symmetric(task.mirror) && std::isfinite(numbers.rms_slope_per_axis))
    add("geometric", !light, [&] {
      const GeometricHarveyShack rays(task.mirror, task.aperture, numbers.rms_slope_per_axis,
                                      Convention::kPhysical, numbers.rms_height);
      return [rays](double r) { return rays.encircled_energy(r, 0); };
    });
  return family;
}

namespace {

// The rows of the models as they are made, with the statistics of each.
struct ModelRows {
  const ChartBench& bench;
  std::vector<Target> aims;
  std::vector<Statistic> statistics;
  double each;  // time for one row [s]
  std::vector<ChartRow> rows = {};
  std::vector<Eigen::VectorXd> values = {};
  std::size_t waves = 0;  // number of rows of waves, which come first

  double cells_across(double pitch) const { return 2 * aperture_radius(bench.task.aperture) / pitch; }
  Eigen::VectorXd on_grid(double pitch) const {
    return by_waves(bench.task, bench.ground, bench.terms, bench.coefficients, statistics, pitch,
                    bench.threads);
  }
  ChartRow& add(const char* method, const char* parameter, double value,
                const std::function<Eigen::VectorXd()>& run) {
    bench.say(fmt::format("chart: {} with {:.0f} {}", method, value, parameter));
    ChartRow row = row_of(method, parameter, value);
    values.emplace_back();
    set_time(measure_time(each, [&] { values.back() = run(); }), &row);
    row.terms = bench.terms.size();
    row.statistics = std::int64_t(statistics.size());
    rows.push_back(row);
    return rows.back();
  }
  void add_waves(double pitch, const ChartClock& clock) {
    // Pitches over the safe one; each grid has twice as many points as the one before.
    for (const double coarser : {4.0, 2.83, 2.0, 1.41, 1.0}) {
      if (waves > 0 && 3 * rows.back().seconds > clock.left()) break;
      ChartRow& row = add("waves", "cells across", std::round(cells_across(coarser * pitch)),
                          [&] { return on_grid(coarser * pitch); });
      row.is_default = coarser == 1 && bench.ground.use.model == FocusModel::kWaves;
      ++waves;
    }
  }
  // The number of rays grows from too few for any statistic to enough for a tenth of a percent. Four times as
  // many rays take four times as long and at least halve the error.
  void add_rays(const ChartClock& clock) {
    const PupilOptions& own = bench.task.trace.pupil;
    const std::int64_t wanted = own.rays.value_or(first_rays(bench.terms.size())), most = 262144;
    bool taken = bench.ground.use.model != FocusModel::kRays;
    for (std::int64_t rays = 4096; rays <= most; rays *= 4) {
      if (rays > 4096 && 4 * rows.back().seconds > clock.left()) break;
      const Workbench at(bench.task, FocusModel::kRays, {own.layout, rays, own.seed}, 0, bench.terms,
                         bench.threads, bench.ground.split);
      ChartRow& row = add("rays", "rays", double(rays), [&] {
        return at.exact(bench.task, bench.coefficients, statistics, bench.threads, nullptr);
      });
      row.rays = at.pupil.size();
      // The study's number, or the next larger one in the chart.
      row.is_default = !taken && (rays >= wanted || rays == most);
      taken = taken || row.is_default;
    }
  }
  // The reference grid has twice the points of the safe one. The error is of second order in the pitch, so
  // the reference has half the error of the safe grid, and the two differ by as much. A coarser last grid
  // gives less.
  void compare(double safe_pitch) {
    bench.say("chart: waves, reference");
    const double pitch = std::sqrt(0.5) * safe_pitch;
    const Eigen::VectorXd truth = on_grid(pitch);
    const std::string reference = fmt::format("waves, {:.0f} cells across", cells_across(pitch));
    for (std::size_t k = 0; k < rows.size(); ++k)
      set_errors(light_errors(values[k], truth, aims), reference, 0, &rows[k]);
    const double doubt = rows[waves - 1].error;
    for (ChartRow& row : rows) row.error_of_reference = doubt;
  }
};

}  // namespace

ChartFamily chart_models(const ChartBench& bench, double seconds) {
  ChartFamily family = family_of("models", "Rays and waves of one surface",
                                 "largest wave-optics error of its encircled energies",
                                 "terms, propagation and statistics", bench.third_of_margin());
  const std::vector<Target> seen = in_light(bench.targets.fitted);
  family.skipped = seen.empty() ? "No encircled energies are among the targets." : why_no_surface(bench);
  if (!family.skipped.empty()) return family;
  const ChartClock clock(seconds);
  const std::vector<Target> aims = aims_of(seen);
  ModelRows models{bench, aims, statistics_of(aims), 0.08 * seconds};
  try {
    const double pitch = wave_pitch(bench.task, bench.terms, seen, bench.ground.split.get());
    models.add_waves(pitch, clock);
    models.add_rays(clock);
    models.compare(pitch);
  } catch (const ComputationError& error) {
    family.skipped = fmt::format("No grid can hold the PSF: {}.", error.what());
    return family;
  }
  family.rows = std::move(models.rows);
  return family;
}

namespace {

// Largest error of a fitted surface by wave optics on the safe grid, over all statistics of the verdict.
double worst_in_light(const FitCase& of, const Attempt& attempt) {
  const JudgedSet judged(in_light(of.targets.fitted), in_light(of.targets.held_out));
  const double pitch =
      wave_pitch(of.task, attempt.result.fitted.terms, all_targets(of.targets), of.ground.split.get());
  FreshStatistics fresh;
  fresh.value =
      by_waves(of.task, of.ground, attempt.result.fitted.terms, attempt.result.fitted.fit.coefficients,
               judged.statistics(), pitch, of.context.threads);
  fresh.standard_error = Eigen::VectorXd::Zero(fresh.value.size());
  double worst = 0;
  for (const EquivalenceMetric& metric : judged.judge(fresh, of.task.equivalence)) {
    if (!std::isfinite(metric.difference)) return std::numeric_limits<double>::quiet_NaN();
    worst = std::max(worst, std::abs(metric.difference));
  }
  return worst;
}

// Orders around the first one of a fit; empty where a fit does not begin with Zernikes.
std::vector<int> orders_of(const ChartBench& bench) {
  const TermsSpec first = first_set(bench.task, bench.ground);
  if (first.automatic() || !first.zernike) return {};
  const int own = first.zernike->n_max.value_or(bench.terms.zernike.back().n);
  std::vector<int> orders = {own};
  for (const double factor : {0.5, 0.75, 1.25})
    if (const int order = std::max(2, int(std::lround(factor * own)));
        std::find(orders.begin(), orders.end(), order) == orders.end())
      orders.push_back(order);
  return orders;
}

TermsSpec zernikes_to(int order, const TermsSpec& asked) {
  TermsSpec terms;
  terms.zernike = ZernikeSpec{asked.zernikes() ? asked.zernikes()->n_min : 2, order};
  terms.covariance = asked.covariance;
  return terms;
}

// Returns why no fit is charted; empty where fits are.
std::string why_no_fit(const ChartBench& bench) {
  if (!bench.ground.psd || !bench.ground.use.obstacle.empty() || bench.ground.all_scatters() ||
      in_light(bench.targets.fitted).empty() || orders_of(bench).empty())
    return "Whole fits are charted only for Zernikes fitted to encircled energies by wave optics, of a "
           "roughness that needs terms.";
  return bench.ground.split && bench.ground.use.model == FocusModel::kRays
             ? "Fits by rays beside a scatter function are not charted."
             : "";
}

}  // namespace

ChartFamily chart_fits(const ChartBench& bench, double seconds) {
  ChartFamily family = family_of("fits", "Whole fits",
                                 "largest wave-optics error of all encircled energies, fitted or held out",
                                 "prior, fit and its start", bench.margin());
  family.skipped = why_no_fit(bench);
  if (!family.skipped.empty()) return family;
  const bool split = bench.ground.split != nullptr;
  const ChartClock clock(seconds);
  const RunContext context{bench.threads, bench.say};
  const std::vector<int> orders = orders_of(bench);
  std::string skipped;
  double last = 0;
  const Task of_rays = seen_by_rays(bench.task);
  struct FitWay {
    const char* method;
    FocusModel model;
    bool coarse_first;
    double dearer;  // time over that of the last fit, for another order or the safe grid
  };
  for (const FitWay& way : {FitWay{"rays", FocusModel::kRays, false, 2},
                            FitWay{"waves, coarse grid first", FocusModel::kWaves, true, 2},
                            FitWay{"waves, safe grid alone", FocusModel::kWaves, false, 10}}) {
    const bool by_rays = way.model == FocusModel::kRays;
    if (by_rays && split) continue;  // rays make no fit with scatter
    const Task& task = by_rays ? of_rays : bench.task;
    // Targets are those of wave optics, even where the study's own come from rays.
    const bool own = bench.ground.use.model == way.model && bench.ground.use.theory == Theory::kGhs;
    const Groundwork ground = own ? bench.ground : lay_groundwork(task, {{}, way.model});
    const TargetSets targets = own ? bench.targets : make_targets(task, ground, bench.threads);
    const FitCase of{task, ground, targets, context};
    if (way.coarse_first) last = 0;
    for (const int order : orders) {
      // The study's own setting is always made, even without time left.
      const bool is_default = order == orders.front() && bench.ground.use.model == way.model &&
                              (way.coarse_first || way.model == FocusModel::kRays);
      if (!is_default && way.dearer * last > clock.left()) {
        skipped += fmt::format("{}{} with n <= {}", skipped.empty() ? "" : ", ", way.method, order);
        continue;
      }
      bench.say(fmt::format("chart: fit of n <= {} by {}", order, way.method));
      const ChartClock fit_clock(0);
      FitPlan plan = make_plan(
          task, std::make_shared<const TermPlan>(plan_terms(task, ground, zernikes_to(order, task.terms))));
      plan.pupil.rays = first_rays(plan.terms->terms.size());
      plan.automatic_rays = false;
      if (way.coarse_first) plan.coarsening = law::kFirstCoarsening;
      Attempt attempt = attempt_fit(of, plan);
      last = fit_clock.elapsed();
      ChartRow row = row_of(way.method, "n_max", order);
      set_time({last, last, last, 1}, &row);
      row.terms = attempt.result.fitted.terms.size();
      row.rays = attempt.result.fitted.rays;
      row.statistics = std::int64_t(targets.fitted.size() + targets.guides.size());
      row.reference = "targets by wave optics";
      row.error_of_reference = 0;
      row.is_default = is_default;
      row.note = attempt.result.fitted.fit.status == FitStatus::kConverged
                     ? "meets its tolerances"
                     : fmt::format("stays {:.2g} tolerances away", attempt.mismatch);
      try {
        if (attempt.result.fitted.fit.coefficients.allFinite())
          row.error = row.error_rms = worst_in_light(of, attempt);
      } catch (const ComputationError& error) {
        row.note += fmt::format("; {}", error.what());
      }
      family.rows.push_back(row);
    }
  }
  if (split)
    family.remark =
        "The roughness is split into terms and scatter, which only waves describe; the terms end at the cut.";
  if (!skipped.empty())
    family.remark +=
        fmt::format("{}Not run for lack of time: {}.", family.remark.empty() ? "" : " ", skipped);
  return family;
}

}  // namespace aberfit::internal
