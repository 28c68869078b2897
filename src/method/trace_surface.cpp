#include "aberfit/method/trace_surface.h"

#include <fmt/format.h>

#include "aberfit/core/errors.h"
#include "aberfit/trace/central_difference.h"
#include "study_surface.h"

namespace aberfit {

GivenSurface surface_of(const Study& study, const Scene& scene, const std::optional<GivenSurface>& given) {
  if (given) return *given;
  double captured = 0;
  GivenSurface drawn{make_terms(study, scene, &captured), {}};
  drawn.coefficients =
      make_study_prior(study, scene, drawn.terms).colour(draw_white(drawn.terms.size(), study.fit.seed));
  return drawn;
}

SurfaceField surface_field(const Study& study, const PupilSample& pupil, const GivenSurface& surface,
                           int threads) {
  if (study.trace.central_difference_step)
    return central_difference_field(study.mirror, pupil, surface.terms, surface.coefficients,
                                    *study.trace.central_difference_step, threads);
  SurfaceField field;
  SurfaceOperator(surface.terms, pupil, {threads, {}, {}}).apply(surface.coefficients, &field);
  return field;
}

TraceReport trace_surface(const Study& study, const std::optional<GivenSurface>& given, int threads) {
  const Scene scene = make_scene(study);
  const TargetSets targets = make_targets(study, scene, threads);
  const GivenSurface surface = surface_of(study, scene, given);
  const FocusPhysics physics = scene.use.physics;
  const bool by_rays = physics == FocusPhysics::kRays;
  if (!by_rays && study.trace.central_difference_step)
    throw InputError(study.path, "/trace/normals",
                     "central differences with trace model \"" + to_string(physics) + '"',
                     "\"analytic\" normals, or trace model \"rays\"");
  const PupilSample pupil = focus_pupil(
      study, physics, physics == FocusPhysics::kWaves ? wave_pitch(study, surface.terms, targets.fitted) : 0);
  const RayBundle nominal = trace_nominal(study.mirror, pupil);
  const SurfaceField field = surface_field(study, pupil, surface, threads);
  const RayBundle rays = trace(study.mirror, pupil, field);
  std::vector<Statistic> statistics;
  for (const Target& target : targets.fitted) statistics.push_back(target.statistic);
  TraceReport report;
  report.warnings = scene.use.warnings;
  const Eigen::VectorXd values =
      by_rays ? evaluate_exact({rays, nominal, field.height, study.trace.centre}, statistics, threads,
                               &report.warnings)
              : focus_statistics({study.mirror, pupil,
                                  SurfaceOperator(surface.terms, pupil, focus_operator(physics, threads)),
                                  physics, study.wavelength, &study.aperture, study.trace.centre},
                                 surface.coefficients, statistics, threads, &report.warnings);
  if (rays.lost > 0)
    report.warnings.push_back(
        {"lost-rays", fmt::format("{} of {} rays miss the focal region", rays.lost, rays.size())});
  report.title = study.title;
  report.theory = targets.theory;
  report.physics = physics;
  report.reason = scene.use.reason;
  report.rays = rays.size();
  report.lost_rays = rays.lost;
  report.terms = surface.terms.size();
  for (std::size_t k = 0; k < statistics.size(); ++k)
    report.statistics.push_back({statistics[k], values[Eigen::Index(k)], targets.fitted[k].value});
  return report;
}

}  // namespace aberfit
