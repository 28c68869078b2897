#include "aberfit/specify/solve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/solve_report.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

// The numbers that the study asks for, with their starts.
std::vector<SolveUnknown> unknowns_of(const Study& study) {
  if (!study.psd)
    throw InputError(study.path, "/roughness", "nothing", "a roughness block: its numbers are solved for");
  const std::vector<PsdNumber> numbers = psd_numbers(study);
  std::vector<std::string> known;
  for (const PsdNumber& number : numbers) known.push_back(number.pointer);
  std::vector<SolveUnknown> unknowns;
  for (std::size_t k = 0; k < study.solve->unknowns.size(); ++k) {
    const std::string& pointer = study.solve->unknowns[k];
    const auto at = std::find(known.begin(), known.end(), pointer);
    if (at == known.end())
      throw InputError(study.path, fmt::format("/solve/for/{}", k), '"' + pointer + '"',
                       known.empty() ? "a roughness with numbers: the model that `aberfit psd` has found, "
                                       "instead of \"measured\""
                                     : fmt::format("a number of the roughness that the study has: {}",
                                                   fmt::join(known, ", ")));
    const PsdNumber& number = numbers[std::size_t(at - known.begin())];
    unknowns.push_back({number.pointer, number.value, number.dimension});
  }
  return unknowns;
}

nlohmann::ordered_json solve_json(const Specification& spec, const Study& study, int threads) {
  return to_json(spec, resolved_study(study), make_provenance(study.fit.seed, threads));
}

}  // namespace

Specification run_solve(const Study& study, const RunOptions& options) {
  if (!study.solve)
    throw InputError(
        study.path, "/solve", "nothing",
        "a block such as {\"for\": [\"/roughness/psd/rms\"], \"so_that\": {\"ee80_diameter\": \"<= "
        "0.6 arcsec\"}}");
  const std::vector<SolveUnknown> unknowns = unknowns_of(study);
  ResultFolder folder(options.output_directory);
  const RunContext context = context_of(options);
  if (options.progress) options.progress("solving");
  SolveOptions how;
  how.contour_decades = study.solve->contour_decades;
  Specification spec = with_fields_of(study, [&] {
    return solve_specification(StudyFamily(study, study.solve->unknowns), unknowns, study.solve->budgets, how,
                               context);
  });
  spec.title = study.title;
  if (folder.wanted()) {
    const std::string to = folder.path();
    if (options.plots && study.output.plots) write_solve_plots(spec, to, &spec.warnings);
    if (!spec.contour.points.empty()) write_file(to + "/contour.csv", contour_csv(spec));
    write_file(to + "/summary.txt", summary_table(spec));
    write_file(to + "/result.json", solve_json(spec, study, context.threads).dump(2) + "\n");
    folder.show();
  }
  return spec;
}

ExitCode solve_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line);
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const Specification spec = run_solve(study, options);
  progress.clear();
  print(line, solve_json(spec, study, context_of(options).threads), summary_table(spec));
  say_where(line);
  return spec.status == SolveStatus::kSolved ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
