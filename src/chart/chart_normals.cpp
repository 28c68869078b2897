#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "aberfit/core/units.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/trace/central_difference.h"
#include "chart_families.h"

namespace aberfit::internal {
namespace {

// RMS rounding of a central difference is kSlopeRounding / step [rad] on a paraboloid with a rim kRim above
// its vertex (PHYSICS 8); it grows with the sag that carries the rounding.
constexpr double kSlopeRounding = 1.2e-19, kRim = 0.2 * 0.2 / (4 * 2.8);  // [m], [m]

// Half decades from 1 nm to 1 mm, the law's best step, and the study's own.
std::set<double> steps(const std::optional<double>& own, const std::optional<StepLaw>& law) {
  std::set<double> all;
  for (int k = 0; k <= 12; ++k) all.insert(1e-9 * std::pow(10.0, k / 2) * (k % 2 == 0 ? 1 : 3));
  if (law) all.insert(law->best_step());
  if (own) all.insert(*own);
  return all;
}

}  // namespace

std::optional<StepLaw> step_law(const ChartBench& bench) {
  const Groundwork& ground = bench.ground;
  if (!ground.psd) return std::nullopt;
  // A band without end: what the terms reach of it.
  double f_max = ground.psd->f_max();
  if (!std::isfinite(radial_moment(*ground.psd, 6)) && !bench.terms.zernike.empty())
    f_max = zernike_cutoff(bench.terms.zernike.back().n, ground.radius);
  const double sixth = radial_moment(*ground.psd, 6, 0, f_max),
               second = radial_moment(*ground.psd, 2, 0, f_max);
  if (!std::isfinite(sixth) || !(second > 0)) return std::nullopt;
  const double per_axis = 2 * std::numbers::pi * std::sqrt(second / 2) * ground.prior_height_factor;
  const double sag = characterise(bench.task.mirror, bench.task.aperture).rim_sag_max;
  // sin(x)/x - 1 = -x^2/6 with x = 2 pi f d cos(angle); <cos^6> / <cos^2> = 5/8 over the angle. For a uniform
  // PSD 0.0932 (2 pi f_max d)^2.
  const double u2 = 4 * std::numbers::pi * std::numbers::pi;
  return StepLaw{u2 / 6 * std::sqrt(5.0 / 8 * sixth / second), kSlopeRounding * sag / kRim / per_axis};
}

namespace {

SurfaceField differences(const ChartBench& bench, const PupilSample& pupil, double step) {
  return central_difference_field(bench.task.mirror, pupil, bench.terms, bench.coefficients, step,
                                  bench.threads);
}

// The study's pupil, with the rays that the budget allows for all steps.
PupilOptions affordable_pupil(const ChartBench& bench, double step_count, double seconds) {
  const Task& task = bench.task;
  constexpr std::int64_t kProbe = 8192;
  const PupilSample few = make_pupil(task.aperture, pupil_of_at_most(task, kProbe));
  const double once = measure_time(0, [&] { differences(bench, few, 1e-6); }).median;
  const double affordable = double(kProbe) * seconds / (3 * step_count * std::max(once, 1e-6));
  return pupil_of_at_most(task, std::int64_t(std::max(double(kProbe), affordable)));
}

void add_row(ChartRow row, const ChartTrace& at, const StatisticErrors& errors, ChartFamily* family) {
  at.set_sizes(&row);
  set_errors(errors, "analytic normals on the same rays", 0, &row);
  family->rows.push_back(std::move(row));
}

}  // namespace

std::vector<ChartFamily> chart_normals(const ChartBench& bench, double seconds) {
  ChartFamily statistics =
      family_of("normals", "Normals, by the statistics", "largest relative error of the statistics",
                "terms, rays and exact statistics", bench.least_tolerance());
  ChartFamily slopes =
      family_of("normals-slope", "Normals, by the slopes", "RMS error of the slopes over their RMS",
                statistics.timed, bench.least_tolerance());
  const std::optional<double>& own_step = bench.task.trace.central_difference_step;
  const std::optional<StepLaw> law = step_law(bench);
  const std::set<double> all = steps(own_step, law);
  ChartTrace at(bench, affordable_pupil(bench, double(all.size()), seconds));
  const double share = seconds / double(all.size() + 1);

  Eigen::VectorXd truth;
  ChartRow analytic = row_of("analytic", "", std::nan(""), "m");
  set_time(measure_time(share, [&] { truth = at.exact(); }), &analytic);
  const SurfaceField true_field = at.field();
  analytic.is_default = !own_step;
  analytic.note = "the reference itself";
  add_row(analytic, at, {0}, &statistics);
  add_row(analytic, at, {0}, &slopes);
  for (const double step : all) {
    bench.say("chart: central differences, step " + format_quantity(step, Dimension::kLength));
    ChartRow row = row_of("central difference", "step", step, "m");
    SurfaceField field;
    Eigen::VectorXd values;
    const ChartTime time = measure_time(share, [&] {
      field = differences(bench, at.pupil(), step);
      values = at.exact_of(field, bench.statistics);
    });
    set_time(time, &row);
    row.is_default = own_step == step;
    if (law && step == law->best_step()) row.note = "best step by the law";
    add_row(row, at, statistic_errors(values, truth, bench.statistics), &statistics);
    if (law) row.note += fmt::format("{}law {:.3g}", row.note.empty() ? "" : "; ", (*law)(step));
    field.slope_x -= true_field.slope_x;
    field.slope_y -= true_field.slope_y;
    const double error =
        std::sqrt(mean_square_slope(at.pupil(), field) / mean_square_slope(at.pupil(), true_field));
    add_row(row, at, {error}, &slopes);
  }
  if (law && !bench.terms.zernike.empty())
    slopes.remark =
        "The law is that of a stationary surface; Zernikes bend more near the rim than their spectrum says, "
        "and so "
        "their truncation error lies above it.";
  return {statistics, slopes};
}

}  // namespace aberfit::internal
