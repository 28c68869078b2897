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

std::vector<double> planes_of_report(const CheckReport& report) {
  return planes_of(statistics_of(report.fitted));
}
std::vector<double> planes_of_report(const MapCheckReport&) { return {}; }

ResultClaim claim_of_check(const Study& study, const RunOptions& options) {
  return claim_of_arrays("check", options, wanted_arrays(study, options));
}

// Writes the report and the arrays of theory, if there shall be any.
template <typename Report>
void write_check(const Study& study, const RunOptions& options, ResultFolder* folder, Report* report) {
  if (!folder->wanted()) return;
  if (const ArrayFormat format = wanted_arrays(study, options); format != ArrayFormat::kNone)
    look_at_theory(
        study, planes_of_report(*report), context_of(options).threads,
        [&](const ArrayInput& focus) { write_arrays(focus, format, folder->path(), &report->warnings); });
  write_result(folder->path(), options,
               {page_of(*report), to_json(*report, resolved_study(study), provenance_of(study, options)),
                typed_study(study)});
  folder->show();
}

// The folder of a check, which by itself writes only arrays.
std::string folder_for_arrays(const Study& study, const RunOptions& options) {
  return wanted_arrays(study, options) == ArrayFormat::kNone ? "" : options.output_directory;
}

}  // namespace

CheckReport run_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  ResultFolder folder(folder_for_arrays(study, options), claim_of_check(study, options));
  CheckReport report = with_fields_of(
      study, [&] { return make_check(study, context_of(options), options.measure_iteration); });
  report.title = study.title;
  write_check(study, options, &folder, &report);
  return report;
}

MapCheckReport run_map_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  ResultFolder folder(folder_for_arrays(study, options), claim_of_check(study, options));
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
  write_check(study, options, &folder, &report);
  return report;
}

Answer internal::answer_check(const SharedStudy& study, const RunOptions& options) {
  const auto of = [&](const auto& report) {
    using Report = std::decay_t<decltype(report)>;
    Answer answer = answer_of(report, ExitCode::kDone, study, options, claim_of_check, write_check<Report>);
    answer.focus = [study, planes = planes_of_report(report),
                    threads = context_of(options).threads](const auto& see) {
      look_at_theory(*study, planes, threads, [&](const ArrayInput& focus) {
        if (!focus.theory)
          throw ComputationError("the study has no roughness, so there is no theory to show");
        see(focus);
      });
    };
    return answer;
  };
  return study->map ? of(run_map_check(*study, options)) : of(run_check(*study, options));
}

ExitCode check_command(CommandLine line) { return study_command(std::move(line), StudyCommand::kCheck); }

}  // namespace aberfit
