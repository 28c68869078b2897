#include "aberfit/method/verify.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "answers.h"
#include "given_surface.h"
#include "output_directory.h"
#include "result_files.h"

namespace aberfit {
using namespace internal;

namespace {

ResultClaim claim_of_verify(const Study& study, const RunOptions& options) {
  return claim_of("verify", options, {}, wanted_pictures(options, &study), verify_picture_names());
}

void write(const Study& study, const RunOptions& options, ResultFolder* folder, VerifyReport* report) {
  if (!folder->wanted()) return;
  const std::string to = folder->path();
  auto drawn = draw_pictures({*report, study.mirror, study.aperture}, to, wanted_pictures(options, &study),
                             &report->warnings);
  write_result(to, options,
               {page_of(*report), to_json(*report, resolved_study(study), provenance_of(study, options)),
                typed_study(study), std::move(drawn)});
  folder->show();
}

}  // namespace

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
  ResultFolder folder(options.output_directory, claim_of_verify(study, options));
  if (options.progress) options.progress("tracing and diffracting realisations of the roughness");
  VerifyReport report = with_fields_of(study, [&] {
    return verify(study, study.verify_draws, given_surface(study, options), context_of(options));
  });
  report.title = study.title;
  write(study, options, &folder, &report);
  return report;
}

Answer internal::answer_verify(const SharedStudy& study, const RunOptions& options) {
  const VerifyReport report = run_verify(*study, options);
  return answer_of(report, report.verdict == Verdict::kEquivalent ? ExitCode::kDone : ExitCode::kNotMet,
                   study, options, claim_of_verify, write);
}

ExitCode verify_command(CommandLine line) { return study_command(std::move(line), StudyCommand::kVerify); }

}  // namespace aberfit
