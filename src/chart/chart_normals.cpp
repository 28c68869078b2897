#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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
std::vector<double> steps(const ChartBench& bench, const std::optional<StepLaw>& law) {
  std::vector<double> all;
  for (int k = 0; k <= 12; ++k) all.push_back(1e-9 * std::pow(10.0, k / 2) * (k % 2 == 0 ? 1 : 3));
  if (law) all.push_back(law->best_step());
  if (bench.task.trace.central_difference_step) all.push_back(*bench.task.trace.central_difference_step);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

double mean_square_slope(const PupilSample& pupil, const SurfaceField& field) {
  return (pupil.weight * (field.slope_x.square() + field.slope_y.square())).sum();
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
PupilSample affordable_pupil(const ChartBench& bench, double step_count, double seconds) {
  const Task& task = bench.task;
  constexpr std::int64_t kProbe = 8192;
  const PupilSample few = make_pupil(task.aperture, pupil_of_at_most(task, kProbe));
  const double once = measure_time(0, [&] { differences(bench, few, 1e-6); }).median;
  const double affordable = double(kProbe) * seconds / (3 * step_count * std::max(once, 1e-6));
  return make_pupil(task.aperture,
                    pupil_of_at_most(task, std::int64_t(std::max(double(kProbe), affordable))));
}

// What analytic normals give, which differences are compared with.
struct Analytic {
  Eigen::VectorXd statistics;
  SurfaceField field;
  double slope_square = 0;
};

// What is the same in all rows.
ChartRow common_row(const ChartBench& bench, const PupilSample& pupil) {
  ChartRow row;
  row.rays = pupil.size();
  row.terms = bench.terms.size();
  row.statistics = std::int64_t(bench.statistics.size());
  row.reference = "analytic normals on the same rays";
  row.error_of_reference = 0;
  row.unit = "m";
  return row;
}

ChartRow analytic_row(const ChartBench& bench, double share, ChartTrace* at, Analytic* analytic) {
  ChartRow row = common_row(bench, at->pupil());
  set_time(
      measure_time(share, [&] { analytic->statistics = at->exact(bench.coefficients, bench.statistics); }),
      &row);
  analytic->field = at->field();
  analytic->slope_square = mean_square_slope(at->pupil(), analytic->field);
  row.method = "analytic";
  row.is_default = !bench.task.trace.central_difference_step;
  row.note = "the reference itself";
  return row;
}

struct StepErrors {
  StatisticErrors statistics, slopes;
};

ChartRow step_row(const ChartBench& bench, double step, double share, const Analytic& analytic,
                  ChartTrace* at, StepErrors* errors) {
  ChartRow row = common_row(bench, at->pupil());
  SurfaceField field;
  Eigen::VectorXd values;
  set_time(measure_time(share,
                        [&] {
                          field = differences(bench, at->pupil(), step);
                          values = at->exact_of(field, bench.statistics);
                        }),
           &row);
  row.method = "central difference";
  row.parameter = "step";
  row.value = step;
  row.is_default =
      bench.task.trace.central_difference_step && step == *bench.task.trace.central_difference_step;
  errors->statistics = statistic_errors(values, analytic.statistics, bench.statistics);
  field.slope_x -= analytic.field.slope_x;
  field.slope_y -= analytic.field.slope_y;
  const double error = std::sqrt(mean_square_slope(at->pupil(), field) / analytic.slope_square);
  errors->slopes = {error, error};
  return row;
}

void add_row(ChartFamily* family, ChartRow row, const StatisticErrors& errors) {
  row.family = family->name;
  row.error = errors.worst;
  row.error_rms = errors.rms;
  family->rows.push_back(std::move(row));
}

}  // namespace

std::vector<ChartFamily> chart_normals(const ChartBench& bench, double seconds) {
  ChartFamily statistics{"normals",
                         "Normals, by the statistics",
                         "largest relative error of the statistics",
                         "terms, rays and exact statistics",
                         bench.tolerance,
                         "tolerance of the targets",
                         {},
                         "",
                         ""};
  ChartFamily slopes{"normals-slope",
                     "Normals, by the slopes",
                     "RMS error of the slopes over their RMS",
                     statistics.timed,
                     bench.tolerance,
                     statistics.tolerance_of,
                     {},
                     "",
                     ""};
  const std::optional<StepLaw> law = step_law(bench);
  const std::vector<double> all = steps(bench, law);
  ChartTrace at(bench, bench.terms, affordable_pupil(bench, double(all.size()), seconds), bench.threads);
  const double share = seconds / double(all.size() + 1);

  Analytic analytic;
  const ChartRow reference = analytic_row(bench, share, &at, &analytic);
  add_row(&statistics, reference, {0, 0});
  add_row(&slopes, reference, {0, 0});
  for (const double step : all) {
    bench.say("chart: central differences, step " + format_quantity(step, Dimension::kLength));
    StepErrors errors;
    ChartRow row = step_row(bench, step, share, analytic, &at, &errors);
    if (law && step == law->best_step()) row.note = "best step by the law";
    add_row(&statistics, row, errors.statistics);
    if (law) row.note += fmt::format("{}law {:.3g}", row.note.empty() ? "" : "; ", (*law)(step));
    add_row(&slopes, row, errors.slopes);
  }
  if (law && !bench.terms.zernike.empty())
    slopes.remark =
        "The law is that of a stationary surface; Zernikes bend more near the rim than their spectrum says, "
        "and so "
        "their truncation error lies above it.";
  mark_rows(&statistics);
  mark_rows(&slopes);
  return {statistics, slopes};
}

}  // namespace aberfit::internal
