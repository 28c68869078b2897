#include "aberfit/method/verify.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/published.h"
#include "aberfit/study/read_study.h"
#include "given_surface.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

VerifyReport run_verify(const Study& study, const RunOptions& options) {
  if (!study.roughness)
    throw InputError(study.path, "/roughness", "nothing",
                     "a roughness block: verify compares with its Harvey-Shack prediction");
  const int threads = options.threads > 0 ? options.threads : available_threads();
  VerifyReport report = with_fields_of(
      study, [&] { return verify(study, study.verify.aside, given_surface(study, options), threads); });
  report.title = study.title;
  report.published = compare_published(study, report.quantities);
  if (!options.output_directory.empty()) {
    write_file(options.output_directory + "/summary.txt", summary_table(report));
    write_file(options.output_directory + "/result.json",
               to_json(report, resolved_study(study)).dump(2) + "\n");
  }
  return report;
}

ExitCode verify_command(CommandLine line) {
  const Study study = read_study(line.study_file);
  choose_output_directory(&line);
  ProgressLine progress(!line.quiet);
  const VerifyReport report = run_verify(study, run_options(line, &progress));
  progress.clear();
  print(line, to_json(report, resolved_study(study)), summary_table(report));
  say_where(line);
  return report.verdict == Verdict::kEquivalent ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
