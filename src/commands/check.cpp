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
#include "answers.h"
#include "array_files.h"
#include "map_fit.h"
#include "result_files.h"

namespace aberfit {
using namespace internal;

namespace {

// Gives the PSF that theory predicts to `look`.
void look_at_theory(const Study& study, const std::vector<double>& planes, int threads,
                    const std::function<void(const ArrayInput&)>& look) {
  std::unique_ptr<FocalLight> theory;
  Groundwork ground;
  if (study.psd) {
    ground = with_fields_of(study, [&] { return lay_groundwork(study); });
    theory = target_light(study, ground, make_pupil(study.aperture, study.trace.pupil), threads);
  }
  look(array_input(study, ground, theory.get(), nullptr, planes));
}

// Writes the report and the arrays of theory.
template <typename Report>
void write_theory(const Study& study, const RunOptions& options, ArrayFormat format,
                  const std::vector<double>& planes, ResultFolder& folder, Report* report) {
  if (format != ArrayFormat::kNone)
    look_at_theory(study, planes, context_of(options).threads, [&](const ArrayInput& focus) {
      write_arrays(focus, format, folder.path(), &report->warnings);
    });
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

Answer internal::answer_check(const Study& study, const RunOptions& options) {
  const auto of = [&](const auto& report, const std::vector<double>& planes) {
    const auto arrays = [study = completed(study), planes, threads = context_of(options).threads] {
      std::optional<FocusArrays> result;
      look_at_theory(study, planes, threads, [&](const ArrayInput& focus) {
        if (!focus.theory)
          throw ComputationError("the study has no roughness, so there is no theory to show");
        result = make_focus_arrays(focus);
      });
      return *result;
    };
    const auto save = [study = completed(study), planes, report](const RunOptions& there) {
      const ArrayFormat format = wanted_arrays(study, there);
      ResultFolder folder(there.output_directory, claim_of_arrays("check", there, format));
      auto written = report;
      write_theory(study, there, format, planes, folder, &written);
    };
    return make_answer(ExitCode::kDone, to_json(report, resolved_study(study), provenance_of(study, options)),
                       page_of(report), arrays, save);
  };
  if (study.map) return of(run_map_check(study, options), {});
  const CheckReport report = run_check(study, options);
  return of(report, planes_of(statistics_of(report.fitted)));
}

ExitCode check_command(CommandLine line) { return study_command(std::move(line), StudyCommand::kCheck); }

}  // namespace aberfit
