#include "aberfit/chart/check.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/map_terms.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "array_files.h"
#include "interrupt.h"
#include "map_fit.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

// Writes the report and the arrays of the PSF that theory predicts.
template <typename Report>
void write_theory(const Study& study, const RunOptions& options, ArrayFormat format,
                  const std::vector<double>& planes, ResultFolder& folder, Report* report) {
  const int threads = context_of(options).threads;
  std::unique_ptr<FocalLight> theory;
  double core_sigma = 0;
  if (study.psd) {
    const Groundwork ground = with_fields_of(study, [&] { return lay_groundwork(study); });
    theory = target_light(study, ground, make_pupil(study.aperture, study.trace.pupil), threads);
    core_sigma = ground.core_sigma;
  }
  write_arrays(study, format, theory.get(), nullptr, planes, core_sigma, folder.path(), &report->warnings);
  write_result(folder.path(), options,
               {page_of(*report), to_json(*report, resolved_study(study), provenance_of(study, options)),
                typed_study(study)});
  folder.show();
}

}  // namespace

CheckReport run_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const ArrayFormat format = wanted_arrays(study, options);
  ResultFolder folder(format == ArrayFormat::kNone ? "" : options.output_directory,
                      claim_of_arrays("check", options, format));
  CheckReport report = with_fields_of(
      study, [&] { return make_check(study, context_of(options), options.measure_iteration); });
  report.title = study.title;
  if (folder.wanted())
    write_theory(study, options, format, planes_of(statistics_of(report.fitted)), folder, &report);
  return report;
}

MapCheckReport run_map_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const ArrayFormat format = wanted_arrays(study, options);
  ResultFolder folder(format == ArrayFormat::kNone ? "" : options.output_directory,
                      claim_of_arrays("check", options, format));
  const LoadedMap loaded = load_map(study);
  const TermSet terms = with_fields_of(study, [&] { return map_terms(study); });
  MapCheckReport report = make_map_check(loaded.map, terms);
  report.title = study.title;
  report.warnings = loaded.warnings;
  if (study.psd)
    report.shares = with_fields_of(study, [&] {
      return lay_out_part(study, terms, part_band(study, terms, loaded.map), context_of(options).threads)
          .ground.shares;
    });
  if (folder.wanted()) write_theory(study, options, format, {}, folder, &report);
  return report;
}

ExitCode check_command(CommandLine line) {
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  RunOptions options = run_options(line, &progress);
  options.measure_iteration = true;
  choose_arrays_directory(study, options, "check", &line);
  options.output_directory = line.output_directory;
  const auto show = [&](const auto& report) {
    progress.clear();
    print(
        line, [&] { return to_json(report, resolved_study(study), provenance_of(study, options)); },
        page_of(report));
    if (wanted_arrays(study, options) != ArrayFormat::kNone) say_where(line);
  };
  if (study.map)
    show(run_map_check(study, options));
  else
    show(run_check(study, options));
  return ExitCode::kDone;
}

}  // namespace aberfit
