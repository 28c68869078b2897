#include "aberfit/method/trace_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/theory/scattered_rays.h"
#include "aberfit/trace/central_difference.h"
#include "aberfit/trace/nominal_surface.h"
#include "aberfit/waves/diffraction_psf.h"
#include "task_surface.h"

namespace aberfit {
using namespace internal;

namespace internal {

GivenSurface surface_of(const Task& task, const Groundwork& ground,
                        const std::optional<GivenSurface>& given) {
  if (given) return *given;
  TermPlan plan = plan_terms(task, ground, task.terms);
  Eigen::VectorXd coefficients = plan.prior.colour(draw_white(plan.terms.size(), task.fit.seed));
  return {std::move(plan.terms), std::move(coefficients)};
}

SurfaceField surface_field(const Task& task, const PupilSample& pupil, const GivenSurface& surface,
                           int threads) {
  if (task.trace.central_difference_step)
    return central_difference_field(task.mirror, pupil, surface.terms, surface.coefficients,
                                    *task.trace.central_difference_step, threads);
  SurfaceField field;
  SurfaceOperator(surface.terms, pupil, {threads, {}, {}}).apply(surface.coefficients, &field);
  return field;
}

std::optional<Warning> central_difference_warning(const Task& task, const PupilSample& pupil,
                                                  const GivenSurface& surface, const SurfaceField& seen,
                                                  int threads) {
  if (!task.trace.central_difference_step) return std::nullopt;
  SurfaceField field;
  SurfaceOperator(surface.terms, pupil, {threads, {}, {}}).apply(surface.coefficients, &field);
  const auto rms = [&](const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
    return std::sqrt((pupil.weight * (x.square() + y.square())).sum() / pupil.weight.sum());
  };
  const double error = rms(seen.slope_x - field.slope_x, seen.slope_y - field.slope_y);
  return Warning{"central-difference",
                 fmt::format("normals by central differences of {} are a hidden low-pass filter (PHYSICS 8). "
                             "Their slopes differ by {} from those of this surface, {} of the RMS slope. "
                             "Leave `trace.normals` out for analytic ones",
                             format_quantity(*task.trace.central_difference_step, Dimension::kLength),
                             format_quantity(error, Dimension::kAngle),
                             format_percent(error / rms(field.slope_x, field.slope_y)))};
}

namespace {

void require_a_value(const std::vector<Statistic>& statistics, const Eigen::VectorXd& values,
                     const Warnings& warnings) {
  if (statistics.empty() || values.array().isFinite().any()) return;
  std::string why;
  for (const Warning& warning : warnings) why += (why.empty() ? ": " : "; ") + warning.message;
  throw ComputationError("no statistic of this surface has a value" + why);
}

// Pitch [m] of the grid for waves. A surface may differ from its specification. Where the usual grid is too
// coarse for its slopes, the pitch shrinks in steps of half the cells until evaluate_diffraction accepts it.
// The grid has at most law::kMostCells cells a side.
double traced_pitch(const Task& task, const Groundwork& ground, const std::vector<Target>& targets,
                    const GivenSurface& surface, int threads) {
  std::vector<double> planes{0};
  for (const Target& target : targets)
    if (const auto dz = plane_of_light(target.statistic)) planes.push_back(*dz);
  const auto [nearest, farthest] = std::minmax_element(planes.begin(), planes.end());
  const double most = 2 * ground.radius / law::kMostCells;
  double pitch = wave_pitch(task, surface.terms, targets, ground.split.get());
  for (; pitch / std::sqrt(2.0) > most; pitch /= std::sqrt(2.0)) {
    const DiffractionPupil cells = diffraction_pupil(task.aperture, task.mirror.focal_length, pitch);
    SurfaceField field;
    SurfaceOperator(surface.terms, cells.sample, focus_operator(FocusModel::kWaves, threads))
        .apply(surface.coefficients, &field);
    const Eigen::ArrayXd known = departure_from_parabola(task.mirror, cells.sample);
    if (known.size() > 0) field.height += known;
    const DiffractionProblem problem{cells, task.mirror.focal_length, task.wavelength};
    const auto aliased = [&](double dz) {
      return check_diffraction(problem, field.height, dz).aliased_share;
    };
    if (!(std::max(aliased(*nearest), aliased(*farthest)) > kMostAliased)) break;
  }
  return pitch;
}

}  // namespace

}  // namespace internal

TraceReport trace_surface(const Task& task, const std::optional<GivenSurface>& given, int threads,
                          const std::function<void(const TracedLight&)>& look) {
  const auto [ground, targets] = lay_out(task, threads);
  const GivenSurface surface = surface_of(task, ground, given);
  const FocusModel model = ground.use.model;
  const bool by_rays = model == FocusModel::kRays;
  if (!by_rays && task.trace.central_difference_step)
    throw FieldError("trace.normals", "central differences with trace model \"" + to_string(model) + '"',
                     "\"analytic\" normals, or trace model \"rays\"");
  const PupilSample pupil =
      focus_pupil(task, model, task.trace.pupil,
                  by_rays ? 0 : traced_pitch(task, ground, targets.fitted, surface, threads));
  const RayBundle nominal = trace_nominal(task.mirror, pupil);
  SurfaceField field = surface_field(task, pupil, surface, threads);
  const auto differences = central_difference_warning(task, pupil, surface, field, threads);
  if (by_rays && ground.split) add_scatter(*ground.split, pupil, kScatterSeed, &field);
  const RayBundle rays = trace(task.mirror, pupil, field);
  const std::vector<Statistic> statistics = statistics_of(targets.fitted);
  TraceReport report;
  report.warnings = ground.use.warnings;
  if (differences) report.warnings.push_back(*differences);
  Eigen::VectorXd values;
  if (by_rays) {
    values = evaluate_exact(
        {rays, nominal, field.height, task.trace.centre, ground.split ? ground.split->rms_height() : 0},
        statistics, threads, &report.warnings);
    if (look) look({ground, targets, pupil, rays, nominal, nullptr, surface.coefficients});
  } else {
    const SurfaceOperator operate(surface.terms, pupil, focus_operator(model, threads));
    LightPath path{task.mirror, pupil, operate, model, task.wavelength, &task.aperture, task.trace.centre};
    path.scatter = ground.split;
    values = focus_statistics(path, surface.coefficients, statistics, threads, &report.warnings);
    if (look) look({ground, targets, pupil, rays, nominal, &path, surface.coefficients});
  }
  if (rays.lost > 0)
    report.warnings.push_back(
        {"lost-rays", fmt::format("{} of {} rays miss the focal region", rays.lost, rays.size())});
  require_a_value(statistics, values, report.warnings);
  report.theory = targets.theory;
  report.model = model;
  report.reason = ground.use.reason;
  report.rays = rays.size();
  report.lost_rays = rays.lost;
  report.terms = surface.terms.size();
  for (std::size_t k = 0; k < statistics.size(); ++k)
    report.statistics.push_back({statistics[k], values[Eigen::Index(k)], targets.fitted[k].value});
  return report;
}

}  // namespace aberfit
