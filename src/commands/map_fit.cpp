#include "map_fit.h"

#include <filesystem>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/map_terms.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/read_study.h"
#include "analytic_normals.h"
#include "fit_files.h"
#include "result_files.h"
#include "unused_parts.h"

namespace aberfit {
using namespace internal;

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
  // Only points on the mirror count, not those in the hole of an annulus or outside a rectangle.
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

}  // namespace internal

namespace {

// The steps of a map take seconds, so no partial result is worth keeping.
void end_if_asked(const RunContext& context) {
  if (context.stopped()) throw Interrupted("stopped before the map was done");
}

// Fits the map in least squares; the irradiance of the result comes later.
ResultDocument fitted_map(const Study& study, const LoadedMap& loaded, const RunOptions& options,
                          const RunContext& context) {
  ResultDocument result;
  static_cast<FitOutcome&>(result) = fit_map_terms(study, loaded.map, study.map->fit, context);
  result.title = study.title;
  result.clear = loaded.clear;
  const Warnings unused = unused_parts(study, "`aberfit solve`");
  result.warnings.insert(result.warnings.begin(), loaded.warnings.begin(), loaded.warnings.end());
  result.warnings.insert(result.warnings.begin(), unused.begin(), unused.end());
  result.provenance = provenance_of(study, options);
  return result;
}

// Describes the terms alone, because there is no specification to judge them by.
void describe_unjudged(const Study& study, const HeightMap& map, const RunOptions& options,
                       const RunContext& context, ResultDocument* result) {
  const PupilSample pupil = make_pupil(study.aperture, study.trace.pupil);
  const SurfaceOperator operate(result->fitted.terms, pupil,
                                focus_operator(FocusModel::kRays, context.threads));
  SurfaceField field;
  operate.apply(result->fitted.fit.coefficients, &field);
  describe_map(study, map, pupil, field, context, result);
  if (options.output_directory.empty()) return;
  Groundwork ground;  // only sizes, as there is no specification
  ground.radius = result->fitted.radius;
  ground.focal_length = study.mirror.focal_length;
  ground.core_sigma = ground.focal_sigma =
      2 * ground.focal_length * result->fitted.surface.rms_slope_per_axis;
  const LightPath focus{study.mirror,     pupil,           operate,           FocusModel::kRays,
                        study.wavelength, &study.aperture, study.trace.centre};
  write_fit(study, ground, options, focus, result);
}

// Judges a part against its specification by irradiance. The part is the terms of the map plus the rest as
// scatter.
ResultDocument judged_map(const Study& study, const LoadedMap& loaded, const RunOptions& options,
                          const RunContext& context) {
  const TermSet terms = map_terms(study);
  const PartBand band = part_band(study, terms, loaded.map);
  context.say("targets");
  const Layout layout = lay_out_part(study, terms, band, context.threads);
  ResultDocument result = fitted_map(study, loaded, options, context);
  if (result.fitted.fit.status == FitStatus::kFailed) return result;
  const FitCase of{study, layout.ground, layout.targets, context};
  judge_part(of, band, &result);
  light_up_map(study, loaded.map, false, context, &result);
  if (options.output_directory.empty()) return result;
  const Workbench bench(study, FocusModel::kWaves, {}, part_pitch(of, result), result.fitted.terms,
                        context.threads, layout.ground.split);
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
  end_if_asked(context);
  ResultDocument result = with_fields_of(study, [&] {
    if (study.psd) return judged_map(study, loaded, there, context);
    ResultDocument terms = fitted_map(study, loaded, options, context);
    if (terms.fitted.fit.status != FitStatus::kFailed)
      describe_unjudged(study, loaded.map, there, context, &terms);
    return terms;
  });
  end_if_asked(context);
  if (result.fitted.fit.status != FitStatus::kFailed) folder.show();
  return result;
}

}  // namespace aberfit
