#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "array_files.h"
#include "given_surface.h"
#include "interrupt.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

TraceReport run_trace(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const int threads = context_of(options).threads;
  const ArrayFormat format = wanted_arrays(study, options);
  ResultFolder folder(format == ArrayFormat::kNone ? "" : options.output_directory,
                      claim_of_arrays("trace", options, format));
  Warnings of_arrays;
  const auto look = [&](const TracedLight& light) {
    if (!folder.wanted()) return;
    const auto theory = target_light(study, light.ground, light.pupil, threads);
    const auto surface = light.waves ? surface_light(*light.waves, light.coefficients, threads)
                                     : ray_light(light.rays, light.nominal, study.trace.centre);
    write_arrays(study, format, theory.get(), surface.get(), planes_of(statistics_of(light.targets.fitted)),
                 light.ground.core_sigma, folder.path(), &of_arrays);
  };
  TraceReport report = with_fields_of(
      study, [&] { return trace_surface(study, given_surface(study, options), threads, look); });
  report.title = study.title;
  report.warnings.insert(report.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  report.warnings.insert(report.warnings.end(), of_arrays.begin(), of_arrays.end());
  if (folder.wanted()) {
    write_result(folder.path(), options,
                 {page_of(report), to_json(report, resolved_study(study), provenance_of(study, options)),
                  typed_study(study)});
    folder.show();
  }
  return report;
}

ExitCode trace_command(CommandLine line) {
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  RunOptions options = run_options(line, &progress);
  choose_arrays_directory(study, options, "trace", &line);
  options.output_directory = line.output_directory;
  const TraceReport report = run_trace(study, options);
  progress.clear();
  print(
      line, [&] { return to_json(report, resolved_study(study), provenance_of(study, options)); },
      page_of(report));
  if (wanted_arrays(study, options) != ArrayFormat::kNone) say_where(line);
  return ExitCode::kDone;
}

}  // namespace aberfit
