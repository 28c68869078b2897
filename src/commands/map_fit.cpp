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
#include "answers.h"
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
FinishedFit unjudged_map(const SharedStudy& study, const LoadedMap& loaded, const RunOptions& options,
                         const RunContext& context) {
  FinishedFit fit{study, fitted_map(*study, loaded, options, context), {}, {}};
  const FittedTerms& fitted = fit.result.fitted;
  if (fit.failed()) return fit;
  const auto bench = std::make_shared<const Workbench>(*study, FocusModel::kRays, study->trace.pupil, 0,
                                                       fitted.terms, context.threads);
  describe_map(*study, loaded.map, bench->pupil, bench->field(fitted.fit.coefficients), context, &fit.result);
  // There are only sizes, as there is no specification.
  fit.ground.radius = fitted.radius;
  fit.ground.focal_length = study->mirror.focal_length;
  fit.ground.core_sigma = fit.ground.focal_sigma =
      2 * fit.ground.focal_length * fitted.surface.rms_slope_per_axis;
  fit.bench = [bench] { return bench; };
  return fit;
}

// Judges a part against its specification by irradiance. The part is the terms of the map plus the rest as
// scatter.
FinishedFit judged_map(const SharedStudy& study, const LoadedMap& loaded, const RunOptions& options,
                       const RunContext& context) {
  const TermSet terms = map_terms(*study);
  const PartBand band = part_band(*study, terms, loaded.map);
  context.say("targets");
  const Layout layout = lay_out_part(*study, terms, band, context.threads);
  FinishedFit fit{study, fitted_map(*study, loaded, options, context), layout.ground, {}};
  if (fit.failed()) return fit;
  const FitCase of{*study, layout.ground, layout.targets, context};
  judge_part(of, band, &fit.result);
  light_up_map(*study, loaded.map, false, context, &fit.result);
  fit.bench = [study, pitch = part_pitch(of, fit.result), terms = fit.result.fitted.terms,
               threads = context.threads, split = layout.ground.split] {
    return std::make_shared<const Workbench>(*study, FocusModel::kWaves, PupilOptions{}, pitch, terms,
                                             threads, split);
  };
  return fit;
}

FinishedFit fit_map(const SharedStudy& study, const RunOptions& options) {
  require_analytic_normals(*study);
  ResultFolder folder(options.output_directory, claim_of_fit(*study, options));
  const RunContext context = context_of(options);
  const LoadedMap loaded = load_map(*study);
  context.stop_if_asked();
  FinishedFit fit = with_fields_of(*study, [&] {
    return study->psd ? judged_map(study, loaded, options, context)
                      : unjudged_map(study, loaded, options, context);
  });
  context.stop_if_asked();
  with_fields_of(*study, [&] { write_fit(options, &folder, &fit); });
  return fit;
}

}  // namespace

ResultDocument run_map_fit(const Study& study, const RunOptions& options) {
  return fit_map(std::make_shared<const Study>(completed(study)), options).result;
}

Answer internal::answer_map_fit(const SharedStudy& study, const RunOptions& options) {
  return answer_of(fit_map(study, options));
}

}  // namespace aberfit
