#include "aberfit/method/verify.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "given_surface.h"
#include "interrupt.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

VerifyReport run_verify(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  if (!study.psd)
    throw InputError(
        study.path, "/roughness", kMissing,
        "`aberfit verify` needs a roughness block, because it compares with its Harvey-Shack prediction");
  if (study.wavelength.is_band())
    throw InputError(
        study.path, "/light", "a band of light",
        "one wavelength, because `verify` compares rays and waves with their theories at one wavelength");
  const PictureOptions pictures = wanted_pictures(options, &study);
  ResultFolder folder(options.output_directory,
                      claim_of("verify", options, {}, pictures, verify_picture_names()));
  if (options.progress) options.progress("tracing and diffracting realisations of the roughness");
  const int threads = context_of(options).threads;
  VerifyReport report = with_fields_of(
      study, [&] { return verify(study, study.verify_draws, given_surface(study, options), threads); });
  report.title = study.title;
  if (folder.wanted()) {
    const std::string to = folder.path();
    auto drawn = draw_pictures({report, study.mirror, study.aperture}, to, pictures, &report.warnings);
    write_result(to, options,
                 {page_of(report), to_json(report, resolved_study(study), provenance_of(study, options)),
                  typed_study(study), std::move(drawn)});
    folder.show();
  }
  return report;
}

ExitCode verify_command(CommandLine line) {
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "verify");
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const VerifyReport report = run_verify(study, options);
  progress.clear();
  print(
      line, [&] { return to_json(report, resolved_study(study), provenance_of(study, options)); },
      page_of(report));
  say_where(line);
  return report.verdict == Verdict::kEquivalent ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
