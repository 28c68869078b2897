#include "aberfit/method/map_terms.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/theory/regime.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

// Terms of a disc cannot be separated on a small part of it: rho^20 at half the radius is 1e-6.
void check_reach(const Task& task, const HeightMap& map) {
  const double across = 2 * aperture_radius(task.aperture),
               cells = (across / map.pitch_x) * (across / map.pitch_y);
  if (cells > law::kMostMapCells)
    throw FieldError(
        "aperture", fmt::format("{:.3g} points of this map in the square around the aperture", cells),
        fmt::format("at most {:.3g} (a smaller aperture, or a coarser map)", law::kMostMapCells));
  const double reach = enclosing_circle(map).radius, radius = aperture_radius(task.aperture);
  if (reach >= 0.5 * radius) return;
  throw FieldError(
      "aperture",
      fmt::format("an aperture of radius {} for a map that reaches {} from its middle",
                  format_quantity(radius, Dimension::kLength), format_quantity(reach, Dimension::kLength)),
      "at most twice the size of the map");
}

Warnings coverage_warnings(const HeightMap& map, double radius) {
  const double reach = enclosing_circle(map).radius;
  if (reach >= 0.98 * radius) return {};
  return {
      {"map-smaller-than-aperture",
       fmt::format("the valid points reach {} from their middle, but the aperture {}. Beyond the map the "
                   "terms are extrapolated; give the aperture the size of the map",
                   format_quantity(reach, Dimension::kLength), format_quantity(radius, Dimension::kLength))}};
}

// Statistics of the fitted terms that are reported without a target.
std::vector<Target> untargeted() {
  std::vector<Target> targets;
  for (const Statistic& statistic :
       {Statistic(EncircledEnergyRadius{0.5, 0}), Statistic(EncircledEnergyRadius{0.8, 0}),
        Statistic(EncircledEnergyRadius{0.9, 0}), Statistic(RingFwhm{}), Statistic(ScatterRms{}),
        Statistic(RmsHeight{})}) {
    Target target;
    target.statistic = statistic;
    target.value = std::nan("");
    targets.push_back(target);
  }
  return targets;
}

// Order of the Zernikes where none is named; for a part with a named cut the terms end at the cut.
int default_order(const Task& task, double radius) {
  if (!task.psd || task.terms.band.rule != BandRule::kCut) return law::kMapOrder;
  const RadialPsd psd(*task.psd);
  const int order = degree_below(psd, task.terms.band.cut, radius, law::kLargestOrder);
  if (order <= law::kLargestOrder) return order;
  throw FieldError(
      "terms.band", format_quantity(task.terms.band.cut, Dimension::kSpatialFrequency),
      fmt::format("at most {}, where order {} ends; or an order (`terms.zernike.n_max`)",
                  format_quantity(terms_end(psd, law::kLargestOrder, radius), Dimension::kSpatialFrequency),
                  law::kLargestOrder));
}

void trace_map(const Task& task, const PupilSample& pupil, const SurfaceField& field, int threads,
               FitOutcome* result) {
  result->fitted.rays = pupil.size();
  const RayBundle nominal = trace_nominal(task.mirror, pupil), rays = trace(task.mirror, pupil, field);
  result->fitted.targets = untargeted();
  const std::vector<Statistic> statistics = statistics_of(result->fitted.targets);
  result->fitted.values = evaluate_exact({rays, nominal, field.height, task.trace.centre}, statistics,
                                         threads, &result->warnings);
}

// Rays describe the spot only if it is several times larger than the diffraction pattern.
bool diffraction_decides(const Task& task, const FitOutcome& result) {
  return result.fitted.values[2] < kAiryRadiiForRays * airy_ee90(task.mirror, task.aperture, task.wavelength);
}

// Replaces the statistics by those of wave optics, where the pupil of the map resolves the terms.
void take_waves(FitOutcome* result) {
  const MapLight& light = *result->map.light;
  result->scene.model = "waves";
  result->fitted.rays = light.cells;
  result->fitted.values.head(4) << light.terms.ee50, light.terms.ee80, light.terms.ee90, light.ring_fwhm;
}

void warn_of_rays(const Task& task, FitOutcome* result) {
  result->warnings.push_back(
      {"rays-not-valid",
       fmt::format(
           "ee90 by rays, {}, is less than {} Airy radii (ee90 {}), so diffraction decides. {}",
           format_quantity(result->fitted.values[2], Dimension::kLength), kAiryRadiiForRays,
           format_quantity(airy_ee90(task.mirror, task.aperture, task.wavelength), Dimension::kLength),
           task.trace.model ? "Leave `trace.model` out to compute the statistics by waves"
                            : "Propagate the exported surface with another program")});
}

EquivalentSurface surface_numbers(const PupilSample& pupil, const SurfaceField& field, double wavelength) {
  EquivalentSurface surface;
  const Eigen::ArrayXd& weight = pupil.weight;
  const double mean = (weight * field.height).sum();
  surface.rms_height = std::sqrt((weight * (field.height - mean).square()).sum());
  surface.rms_slope_per_axis =
      std::sqrt((weight * (field.slope_x.square() + field.slope_y.square())).sum() / 2);
  surface.g = 4 * kPi * surface.rms_height / wavelength;
  surface.kappa = std::nan("");
  return surface;
}

}  // namespace

TermSet map_terms(const Task& task) {
  if (task.terms.fourier)
    throw FieldError("terms.fourier", "Fourier terms for a map", "zernike or spherical terms");
  TermSet terms;
  terms.radius = aperture_radius(task.aperture);
  if (const std::optional<ZernikeSpec> zernikes = task.terms.zernikes())
    terms.zernike = zernike_modes(zernikes->n_min,
                                  zernikes->n_max ? *zernikes->n_max : default_order(task, terms.radius));
  terms.spherical = task.terms.spherical;
  return terms;
}

FitOutcome fit_map_terms(const Task& task, const HeightMap& map, const MapFitOptions& how,
                         const RunContext& context) {
  check_reach(task, map);
  const auto began = std::chrono::steady_clock::now();
  FitOutcome result;
  result.judgement.confidence = task.equivalence.confidence;
  result.scene.theory = "map";
  result.fitted.terms = map_terms(task);
  result.fitted.radius = result.fitted.terms.radius;
  result.warnings = coverage_warnings(map, result.fitted.radius);
  context.say("least squares");
  MapFitOptions options = how;
  options.threads = context.threads;
  result.map.fit = fit_map(map, result.fitted.terms, options);
  result.warnings.insert(result.warnings.end(), result.map.fit->warnings.begin(),
                         result.map.fit->warnings.end());

  FitResult& fit = result.fitted.fit;
  const bool failed = result.map.fit->status == MapFitResult::Status::kFailed;
  const bool full_rank = result.map.fit->status == MapFitResult::Status::kConverged;
  fit.status = failed ? FitStatus::kFailed : full_rank ? FitStatus::kConverged : FitStatus::kNotConverged;
  fit.message = result.map.fit->message;
  fit.coefficients = result.map.fit->coefficients;
  fit.coefficient_std = result.map.fit->coefficient_std;
  fit.rank = result.map.fit->rank;
  fit.null_directions = int(result.fitted.terms.size()) - fit.rank;
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

void light_up_map(const Task& task, const HeightMap& map, bool with_ring, const RunContext& context,
                  FitOutcome* outcome) {
  if (context.stopped()) throw Interrupted("stopped before the map was done");
  context.say("PSF of the map");
  outcome->map.panels =
      map_panels(map, task.aperture, outcome->fitted.terms, *outcome->map.fit, context.threads);
  outcome->map.light = map_light(task, *outcome->map.panels, outcome->fitted.terms, *outcome->map.fit,
                                 with_ring, context.threads);
  const Warnings& warnings = outcome->map.light->warnings;
  outcome->warnings.insert(outcome->warnings.end(), warnings.begin(), warnings.end());
}

void describe_map(const Task& task, const HeightMap& map, const PupilSample& pupil, const SurfaceField& field,
                  const RunContext& context, FitOutcome* outcome) {
  const PhysicsChoice use = choose_physics(task, requested_physics(task), nullptr);
  trace_map(task, pupil, field, context.threads, outcome);
  const bool small = diffraction_decides(task, *outcome);
  const bool waves =
      task.trace.model ? *task.trace.model == FocusModel::kWaves : small && use.obstacle.empty();
  light_up_map(task, map, waves, context, outcome);
  const std::string& obstacle = outcome->map.light->terms.obstacle;
  if (task.trace.model && waves && !obstacle.empty())
    throw FieldError("trace.model", "\"waves\", but " + obstacle, "\"auto\", \"rays\"");
  if (waves && obstacle.empty())
    take_waves(outcome);
  else if (small)
    warn_of_rays(task, outcome);
  outcome->fitted.surface = surface_numbers(pupil, field, task.wavelength);
}

}  // namespace aberfit
