#include "aberfit/commands/run.h"
#include "aberfit/report/trace_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "given_surface.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

TraceReport run_trace(const Study& study, const RunOptions& options) {
  const int threads = context_of(options).threads;
  TraceReport report =
      with_fields_of(study, [&] { return trace_surface(study, given_surface(study, options), threads); });
  report.title = study.title;
  return report;
}

ExitCode trace_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  const TraceReport report = run_trace(study, run_options(line, &progress));
  progress.clear();
  print(line, to_json(report, resolved_study(study)), summary_table(report));
  return ExitCode::kDone;
}

}  // namespace aberfit
