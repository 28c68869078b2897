#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "answers.h"
#include "array_files.h"
#include "given_surface.h"
#include "result_files.h"

namespace aberfit {
using namespace internal;

namespace {

using Look = std::function<void(const ArrayInput&)>;

// Traces the surface of a study. look: receives its focus and that of theory; may be empty.
TraceReport traced(const Study& study, const RunOptions& options, const Look& look) {
  const int threads = context_of(options).threads;
  const auto show = [&](const TracedLight& light) {
    const auto theory = target_light(study, light.ground, light.pupil, threads);
    const auto surface = light.waves ? surface_light(*light.waves, light.coefficients, threads)
                                     : ray_light(light.rays, light.nominal, study.trace.centre);
    look(array_input(study, light.ground, theory.get(), surface.get(),
                     planes_of(statistics_of(light.targets.fitted))));
  };
  TraceReport report = with_fields_of(study, [&] {
    return trace_surface(study, given_surface(study, options), threads,
                         look ? std::function<void(const TracedLight&)>(show) : nullptr);
  });
  report.title = study.title;
  report.warnings.insert(report.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  return report;
}

ResultClaim claim_of_trace(const Study& study, const RunOptions& options) {
  return claim_of_arrays("trace", options, wanted_arrays(study, options));
}

TraceReport trace_and_write(const Study& study, const RunOptions& options, ResultFolder* folder) {
  if (!folder->wanted()) return traced(study, options, {});
  Warnings of_arrays;
  TraceReport report = traced(study, options, [&](const ArrayInput& focus) {
    write_arrays(focus, wanted_arrays(study, options), folder->path(), &of_arrays);
  });
  report.warnings.insert(report.warnings.end(), of_arrays.begin(), of_arrays.end());
  write_result(folder->path(), options,
               {page_of(report), to_json(report, resolved_study(study), provenance_of(study, options)),
                typed_study(study)});
  folder->show();
  return report;
}

}  // namespace

TraceReport run_trace(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const bool writes = wanted_arrays(study, options) != ArrayFormat::kNone;
  ResultFolder folder(writes ? options.output_directory : "", claim_of_trace(study, options));
  return trace_and_write(study, options, &folder);
}

Answer internal::answer_trace(const SharedStudy& study, const RunOptions& given) {
  RunOptions options = given;  // with the surface itself, as its file may be gone when arrays are asked for
  if (const auto surface = given_surface(*study, given))
    options.surface = std::make_shared<const GivenSurface>(*surface);
  const TraceReport report = run_trace(*study, options);
  RunOptions how;
  how.threads = options.threads;
  how.surface = options.surface;
  Answer answer{ExitCode::kDone, page_of(report)};
  answer.document = [=] { return to_json(report, resolved_study(*study), provenance_of(*study, how)); };
  answer.focus = [=](const auto& see) { traced(*study, how, see); };
  answer.save = [=](const RunOptions& wanted) {
    RunOptions there = wanted;
    there.surface = how.surface;
    ResultFolder folder(there.output_directory, claim_of_trace(*study, there));
    trace_and_write(*study, there, &folder);
  };
  return answer;
}

ExitCode trace_command(CommandLine line) { return study_command(std::move(line), StudyCommand::kTrace); }

}  // namespace aberfit
