#include "aberfit/method/verify.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/published.h"
#include "aberfit/study/read_study.h"
#include "given_surface.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

// A row that points to a picture points to one that exists.
void check_pictures(const Study& study) {
  const std::vector<std::string>& names = verify_picture_names();
  for (std::size_t k = 0; k < study.verify.published.size(); ++k) {
    const std::string& picture = study.verify.published[k].picture;
    if (!picture.empty() && std::find(names.begin(), names.end(), picture) == names.end())
      throw InputError(study.path, fmt::format("/verify/published/{}/picture", k), '"' + picture + '"',
                       fmt::format("{}", fmt::join(names, ", ")));
  }
}

}  // namespace

VerifyReport run_verify(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  if (!study.psd)
    throw InputError(study.path, "/roughness", "nothing",
                     "a roughness block: verify compares with its Harvey-Shack prediction");
  if (study.wavelength.is_band())
    throw InputError(study.path, "/light", "a band of light",
                     "one wavelength: verify holds each kind of light against its theory");
  check_pictures(study);  // before anything is computed
  std::vector<std::string> pictures = verify_picture_names();
  pictures.emplace_back("frequency_");  // data of frequency_sampling
  ResultFolder folder(options.output_directory, claim_of("verify", options, {"summary.txt", "result.json"},
                                                         options.plots && study.output.plots, pictures));
  if (options.progress) options.progress("tracing and diffracting draws of the roughness");
  const int threads = context_of(options).threads;
  VerifyReport report = with_fields_of(
      study, [&] { return verify(study, study.verify.aside, given_surface(study, options), threads); });
  report.title = study.title;
  report.published = compare_published(study, report.quantities);
  if (folder.wanted()) {
    const std::string to = folder.path();
    if (options.plots && study.output.plots)
      write_verify_plots(report, study.mirror, study.aperture, study.wavelength, to, &report.warnings);
    write_file(to + "/summary.txt", summary_table(report));
    write_file(to + "/result.json", to_json(report, resolved_study(study)).dump(2) + "\n");
    folder.show();
  }
  return report;
}

ExitCode verify_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "verify");
  ProgressLine progress(!line.quiet);
  const VerifyReport report = run_verify(study, run_options(line, &progress));
  progress.clear();
  print(line, to_json(report, resolved_study(study)), summary_table(report));
  say_where(line);
  return report.verdict == Verdict::kEquivalent ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
