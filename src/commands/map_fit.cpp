#include "map_fit.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "aberfit/commands/run.h"
#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/map_light.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/regime.h"
#include "analytic_normals.h"
#include "fit_files.h"
#include "unused_parts.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr int kDefaultOrder = 20;      // 231 terms: what OpticStudio's Zernike surfaces take
constexpr int kMostDefaultOrder = 60;  // 1891 terms: about a minute for 1e5 points

// Terms of a disc cannot be told apart on a small part of it: rho^20 at half the radius is 1e-6.
void check_reach(const Study& study, const HeightMap& map) {
  constexpr double kMostCells = 6.4e7;  // of the square around the aperture, in light
  const double across = 2 * aperture_radius(study.aperture),
               cells = (across / map.pitch_x) * (across / map.pitch_y);
  if (cells > kMostCells)
    throw InputError(study.path, "/aperture",
                     fmt::format("{:.3g} points of this map across the square of the aperture", cells),
                     fmt::format("at most {:.3g}: a smaller aperture, or a coarser map", kMostCells));
  const double reach = enclosing_circle(map).radius, radius = aperture_radius(study.aperture);
  if (reach >= 0.5 * radius) return;
  throw InputError(
      study.path, "/aperture",
      fmt::format("an aperture of radius {} for a map that reaches {} from its middle",
                  format_quantity(radius, Dimension::kLength), format_quantity(reach, Dimension::kLength)),
      "at most twice the size of the map");
}

Warnings coverage_warnings(const HeightMap& map, double radius) {
  const double reach = enclosing_circle(map).radius;
  if (reach >= 0.98 * radius) return {};
  return {{"map-smaller-than-aperture",
           fmt::format(
               "the valid points reach {} from their middle, the aperture {}: beyond the map the terms are "
               "extrapolated; give the aperture the size of the map",
               format_quantity(reach, Dimension::kLength), format_quantity(radius, Dimension::kLength))}};
}

// Nothing to compare with: the statistics of the fitted terms are reported, their targets do not exist.
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

// Without a named order the terms of a part end where its scatter begins.
int default_order(const Study& study, double radius) {
  if (!study.psd || study.terms.band.rule != BandRule::kCut) return kDefaultOrder;
  const RadialPsd psd(*study.psd);
  const int order = degree_below(psd, study.terms.band.cut, radius, kMostDefaultOrder);
  if (order <= kMostDefaultOrder) return order;
  throw InputError(
      study.path, "/terms/band", format_quantity(study.terms.band.cut, Dimension::kSpatialFrequency),
      fmt::format("at most {}, where order {} ends; or an order (`terms.zernike.n_max`)",
                  format_quantity(terms_end(psd, kMostDefaultOrder, radius), Dimension::kSpatialFrequency),
                  kMostDefaultOrder));
}

}  // namespace

namespace internal {

LoadedMap load_map(const Study& study) {
  LoadedMap loaded;
  const MapTarget& target = *study.map;
  Measurement data = load_measurement(target.source, std::filesystem::path(study.path).parent_path().string(),
                                      study.path, "/target/map/file", &loaded.clear);
  auto* map = std::get_if<HeightMap>(&data);
  if (!map) throw InputError(study.path, "/target/map/file", "a profile", "a map");
  const double x0 = map->x0, y0 = map->y0;
  if (target.origin == "grid") centre_on_grid(map);
  if (target.origin == "circle") {
    const Circle circle = enclosing_circle(*map);
    move_origin(map, circle.x, circle.y);
  }
  loaded.clear.x += map->x0 - x0, loaded.clear.y += map->y0 - y0;
  // Only what is mirror: the hole of an annulus and the corners around a rectangle are not.
  for (Eigen::Index row = 0; row < map->rows(); ++row)
    for (Eigen::Index column = 0; column < map->columns(); ++column)
      if (!aperture_holds(study.aperture, map->x(column), map->y(row)))
        map->height(row, column) = std::nan("");
  if (valid_count(*map) == 0)
    throw InputError(study.path, "/target/map", "no valid point inside the aperture",
                     "a map that covers the aperture");
  loaded.warnings = study.data_warnings;
  const Warnings seen = screen(&data, target.outliers, {});
  loaded.warnings.insert(loaded.warnings.end(), map->warnings.begin(), map->warnings.end());
  loaded.warnings.insert(loaded.warnings.end(), seen.begin(), seen.end());
  loaded.map = std::move(*map);
  return loaded;
}

TermSet map_terms(const Study& study, double radius) {
  if (study.terms.fourier)
    throw InputError(study.path, "/terms/fourier", "Fourier terms for a map", "zernike or spherical terms");
  TermSet terms;
  terms.radius = radius;
  if (const std::optional<ZernikeSpec> zernikes = study.terms.zernikes())
    terms.zernike =
        zernike_modes(zernikes->n_min, zernikes->n_max ? *zernikes->n_max : default_order(study, radius));
  terms.spherical = study.terms.spherical;
  return terms;
}

}  // namespace internal

namespace {

// Least squares of the map: everything but the light of what came.
ResultDocument fitted_map(const Study& study, const LoadedMap& loaded, const RunOptions& options,
                          int threads) {
  const HeightMap& map = loaded.map;
  const auto began = std::chrono::steady_clock::now();
  ResultDocument result;
  result.title = study.title;
  result.confidence = study.equivalence.confidence;
  result.theory = "map";
  result.radius = aperture_radius(study.aperture);
  result.terms = map_terms(study, result.radius);
  result.clear = loaded.clear;
  result.warnings = unused_parts(study, "`aberfit solve`");
  const Warnings coverage = coverage_warnings(map, result.radius);
  result.warnings.insert(result.warnings.end(), coverage.begin(), coverage.end());
  result.warnings.insert(result.warnings.end(), loaded.warnings.begin(), loaded.warnings.end());
  if (options.progress) options.progress("least squares");
  MapFitOptions how = study.map->fit;
  how.threads = threads;
  result.map = fit_map(map, result.terms, how);
  result.warnings.insert(result.warnings.end(), result.map->warnings.begin(), result.map->warnings.end());

  FitResult& fit = result.fit;
  const bool failed = result.map->status == MapFitResult::Status::kFailed;
  const bool full_rank = result.map->status == MapFitResult::Status::kConverged;
  fit.status = failed ? FitStatus::kFailed : full_rank ? FitStatus::kConverged : FitStatus::kNotConverged;
  fit.message = result.map->message;
  fit.coefficients = result.map->coefficients;
  fit.coefficient_std = result.map->coefficient_std;
  fit.rank = result.map->rank;
  fit.null_directions = int(result.terms.size()) - fit.rank;
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  result.provenance = make_provenance(how.seed, threads);
  result.provenance.libraries["ceres"] = solver_version();
  return result;
}

// Nothing of a map is worth keeping by itself: its steps take seconds.
void end_if_asked(const RunContext& context) {
  if (context.stopped()) throw Interrupted("stopped before the map was done");
}

// What the map and its terms look like, and their light.
void light_up(const Study& study, const HeightMap& map, bool with_ring, const RunContext& context,
              ResultDocument* result) {
  end_if_asked(context);
  context.say("light of the map");
  result->map_panels = map_panels(map, study.aperture, result->terms, *result->map, context.threads);
  result->map_light =
      map_light(study, *result->map_panels, result->terms, *result->map, with_ring, context.threads);
  const Warnings& warnings = result->map_light->warnings;
  result->warnings.insert(result->warnings.end(), warnings.begin(), warnings.end());
}

// The focal statistics of the fitted terms by rays.
void trace_map(const Study& study, const PupilSample& pupil, const SurfaceField& field, int threads,
               ResultDocument* result) {
  result->rays = pupil.size();
  const RayBundle nominal = trace_nominal(study.mirror, pupil), rays = trace(study.mirror, pupil, field);
  result->targets = untargeted();
  const std::vector<Statistic> statistics = statistics_of(result->targets);
  result->fitted = evaluate_exact({rays, nominal, field.height, study.trace.centre}, statistics, threads,
                                  &result->warnings);
}

// A spot by rays that is not several times the diffraction pattern is no picture of the light.
bool diffraction_decides(const Study& study, const ResultDocument& result) {
  return result.fitted[2] < kAiryRadiiForRays * airy_ee90(study.mirror, study.aperture, study.wavelength);
}

// The same statistics in light, where the pupil of the map holds the terms.
void take_waves(ResultDocument* result) {
  const MapLight& light = *result->map_light;
  result->model = "waves";
  result->rays = light.cells;
  result->fitted.head(4) << light.terms.ee50, light.terms.ee80, light.terms.ee90, light.ring_fwhm;
}

void warn_of_rays(const Study& study, ResultDocument* result) {
  result->warnings.push_back(
      {"rays-not-valid",
       fmt::format(
           "ee90 by rays, {}, is less than {} Airy radii (ee90 {}): diffraction decides there. {}",
           format_quantity(result->fitted[2], Dimension::kLength), kAiryRadiiForRays,
           format_quantity(airy_ee90(study.mirror, study.aperture, study.wavelength), Dimension::kLength),
           study.trace.model ? "Leave `trace.model` out, and the statistics are those of waves"
                             : "The exported surface can be propagated as it is")});
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

// Of the terms alone: nothing says what the part should be. By rays or waves as a scene without roughness
// has it, and by waves where rays would draw a spot that light does not make.
void describe_unjudged(const Study& study, const HeightMap& map, const RunOptions& options,
                       const RunContext& context, ResultDocument* result) {
  const PhysicsChoice use = choose_physics(study, requested_physics(study), nullptr);
  const PupilSample pupil = make_pupil(study.aperture, study.trace.pupil);
  const SurfaceOperator operate(result->terms, pupil, focus_operator(FocusModel::kRays, context.threads));
  SurfaceField field;
  operate.apply(result->fit.coefficients, &field);
  trace_map(study, pupil, field, context.threads, result);
  const bool small = diffraction_decides(study, *result);
  const bool waves =
      study.trace.model ? *study.trace.model == FocusModel::kWaves : small && use.obstacle.empty();
  light_up(study, map, waves, context, result);
  const std::string& obstacle = result->map_light->terms.obstacle;
  if (study.trace.model && waves && !obstacle.empty())
    throw FieldError("trace.model", "\"waves\", but " + obstacle, "\"auto\", \"rays\"");
  if (waves && obstacle.empty())
    take_waves(result);
  else if (small)
    warn_of_rays(study, result);
  result->surface = surface_numbers(pupil, field, study.wavelength);
  if (options.output_directory.empty()) return;
  Groundwork ground;  // a map has no specification: only sizes
  ground.radius = result->radius;
  ground.focal_length = study.mirror.focal_length;
  ground.core_sigma = ground.focal_sigma = 2 * ground.focal_length * result->surface.rms_slope_per_axis;
  const LightPath focus{study.mirror,     pupil,           operate,           FocusModel::kRays,
                        study.wavelength, &study.aperture, study.trace.centre};
  write_fit(study, ground, options, focus, result);
}

// A part and its specification: the terms of the map, the rest as scatter, light's verdict.
ResultDocument judged_map(const Study& study, const LoadedMap& loaded, const RunOptions& options,
                          const RunContext& context) {
  const TermSet terms = map_terms(study, aperture_radius(study.aperture));
  const PartBand band = part_band(study, terms, loaded.map);
  context.say("targets");
  const Layout layout = lay_out_part(study, terms, band, context.threads);
  ResultDocument result = fitted_map(study, loaded, options, context.threads);
  if (result.fit.status == FitStatus::kFailed) return result;
  const FitCase of{study, layout.ground, layout.targets, context};
  judge_part(of, band, &result);
  light_up(study, loaded.map, false, context, &result);
  if (options.output_directory.empty()) return result;
  const Workbench bench(study, FocusModel::kWaves, {}, part_pitch(of, result), result.terms, context.threads,
                        layout.ground.split);
  write_fit(study, layout.ground, options, bench.focus(study), &result);
  return result;
}

}  // namespace

ResultDocument run_map_fit(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  require_analytic_normals(study);
  ResultFolder folder(options.output_directory, claim_of_fit(study, options));
  RunOptions there = options;
  there.output_directory = folder.path();
  const RunContext context = context_of(options);
  const LoadedMap loaded = load_map(study);
  check_reach(study, loaded.map);
  end_if_asked(context);
  ResultDocument result = with_fields_of(study, [&] {
    if (study.psd) return judged_map(study, loaded, there, context);
    ResultDocument terms = fitted_map(study, loaded, options, context.threads);
    if (terms.fit.status != FitStatus::kFailed) describe_unjudged(study, loaded.map, there, context, &terms);
    return terms;
  });
  end_if_asked(context);
  if (result.fit.status != FitStatus::kFailed) folder.show();
  return result;
}

}  // namespace aberfit
