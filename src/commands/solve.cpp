#include "aberfit/specify/solve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/theory_values.h"
#include "aberfit/report/ceilings_report.h"
#include "aberfit/report/psd_of_focus_report.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/solve_report.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "output_directory.h"
#include "solve_focus.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

// Of a Specification, of Ceilings or of a PsdOfFocus.
template <typename Answer>
nlohmann::ordered_json answer_json(const Answer& answer, const Study& study, int threads) {
  return to_json(answer, resolved_study(study), make_provenance(study.fit.seed, threads));
}

void require_block(const Study& study) {
  if (!study.solve)
    throw InputError(
        study.path, "/solve", "nothing",
        "a block such as {\"for\": [\"/roughness/psd/rms\"], \"so_that\": {\"ee80_diameter\": \"<= "
        "0.6 arcsec\"}}");
}

// Both commands' pictures, table and document, beside what they have of their own.
template <typename Answer>
void write_answer(const Answer& answer, const Study& study, int threads, const std::string& to) {
  write_file(to + "/summary.txt", summary_table(answer));
  write_file(to + "/result.json", answer_json(answer, study, threads).dump(2) + "\n");
}

// Transfer functions multiply; slopes of turbulence have no variance.
void require_light_of_path(const Study& study) {
  const Theory theory = theory_of_targets(study, RadialPsd(*study.psd));
  if (theory != Theory::kGhs)
    throw FieldError("target.theory", to_string(theory), "\"auto\" or \"ghs\" beside solve.with");
}

}  // namespace

std::vector<SolveUnknown> internal::solve_unknowns(const Study& study) {
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

Specification run_solve(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  require_block(study);
  if (study.solve->budgets.empty())
    throw InputError(study.path, "/solve/so_that", "nothing",
                     "budgets that have to hold; a measured focus is for `aberfit solve` alone");
  if (study.solve->unknowns.empty())
    throw InputError(study.path, "/solve/for", "nothing",
                     "one or two numbers of the roughness; ceilings are for `aberfit solve` alone");
  const std::vector<SolveUnknown> unknowns = solve_unknowns(study);
  ResultFolder folder(options.output_directory,
                      claim_of("solve", options, {"contour.csv", "summary.txt", "result.json"},
                               options.plots && study.output.plots, {"contour"}));
  const RunContext context = context_of(options);
  if (options.progress) options.progress("solving");
  SolveOptions how;
  how.contour_decades = study.solve->contour_decades;
  how.confidence = study.solve->confidence.value_or(0);
  const StudyFamily own(study, study.solve->unknowns);
  const Contributors others = study.solve->with ? contributors(*study.solve->with) : Contributors{};
  Specification spec = with_fields_of(study, [&] {
    if (others.empty()) return solve_specification(own, unknowns, study.solve->budgets, how, context);
    require_light_of_path(study);
    Specification whole = solve_specification(with_contributors(own, others, study.solve->budgets), unknowns,
                                              study.solve->budgets, how, context);
    if (whole.status == SolveStatus::kSolved)
      whole.uses = uses_of_budget(own(whole.solutions.front().at), others, whole.budgets, context.threads);
    return whole;
  });
  spec.title = study.title;
  spec.warnings.insert(spec.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  if (folder.wanted()) {
    const std::string to = folder.path();
    if (options.plots && study.output.plots) write_solve_plots(spec, to, &spec.warnings);
    if (!spec.contour.points.empty()) write_file(to + "/contour.csv", contour_csv(spec));
    write_answer(spec, study, context.threads, to);
    folder.show();
  }
  return spec;
}

Ceilings run_ceilings(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  require_block(study);
  if (!study.solve->ceilings)
    throw InputError(study.path, "/solve/ceilings", "nothing",
                     "an object, e.g. {} or {\"f_max\": \"1 /mm\"}");
  ResultFolder folder(options.output_directory,
                      claim_of("solve", options, {"ceilings.csv", "summary.txt", "result.json"},
                               options.plots && study.output.plots, {"ceilings"}));
  const RunContext context = context_of(options);
  if (options.progress) options.progress("ceilings");
  Ceilings ceilings = with_fields_of(
      study, [&] { return find_ceilings(study, *study.solve->ceilings, study.solve->budgets, context); });
  ceilings.title = study.title;
  ceilings.warnings.insert(ceilings.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  if (folder.wanted()) {
    const std::string to = folder.path();
    if (options.plots && study.output.plots) write_ceilings_plots(ceilings, to, &ceilings.warnings);
    if (ceilings.reason.empty()) write_file(to + "/ceilings.csv", ceilings_csv(ceilings));
    write_answer(ceilings, study, context.threads, to);
    folder.show();
  }
  return ceilings;
}

ExitCode solve_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "solve");
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const auto show = [&](const auto& answer, bool found) {
    progress.clear();
    print(line, answer_json(answer, study, context_of(options).threads), summary_table(answer));
    say_where(line);
    return found ? ExitCode::kDone : ExitCode::kNotMet;
  };
  if (study.solve && study.solve->ceilings) {
    const Ceilings ceilings = run_ceilings(study, options);
    return show(ceilings, ceilings.reason.empty());
  }
  if (study.solve && study.solve->focus) {
    const PsdOfFocus found = run_psd_of_focus(study, options);
    return show(found, found.status == PsdOfFocusStatus::kFitted);
  }
  const Specification spec = run_solve(study, options);
  return show(spec, spec.status == SolveStatus::kSolved);
}

}  // namespace aberfit
