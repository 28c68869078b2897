#include "aberfit/method/verify.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
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

// What stands beside a published number [SI]; NaN: nothing.
double quantity(const Study& study, const PublishedNumber& row, std::size_t at,
                const Quantities& quantities) {
  if (!row.formula.empty()) return evaluate_formula(row.formula, row.inputs, study);
  if (row.quantity.empty()) return std::nan("");
  const auto found = quantities.find(row.quantity);
  if (found == quantities.end()) {
    std::string known;
    for (const auto& [name, value] : quantities) known += (known.empty() ? "" : ", ") + name;
    throw InputError(study.path, fmt::format("/verify/published/{}/quantity", at), "\"" + row.quantity + "\"",
                     known);
  }
  return found->second;
}

}  // namespace

VerifyReport run_verify(const Study& study, const RunOptions& options) {
  if (!study.roughness)
    throw InputError(study.path, "/roughness", "nothing",
                     "a roughness block: verify compares with its Harvey-Shack prediction");
  const int threads = context_of(options).threads;
  VerifyReport report = with_fields_of(
      study, [&] { return verify(study, study.verify.aside, given_surface(study, options), threads); });
  report.title = study.title;
  for (std::size_t k = 0; k < study.verify.published.size(); ++k) {
    const PublishedNumber& row = study.verify.published[k];
    const double ours = quantity(study, row, k, report.quantities) / row.scale;
    report.published.push_back({row.label, row.value, ours, row.unit,
                                row.formula.empty() ? row.quantity : row.formula, row.reading});
  }
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
