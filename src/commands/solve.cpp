#include "aberfit/specify/solve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/theory_values.h"
#include "aberfit/report/ceilings_report.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/psd_of_focus_report.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/solve_report.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "answers.h"
#include "output_directory.h"
#include "result_files.h"
#include "solve_focus.h"

namespace aberfit {
using namespace internal;

namespace {

// The JSON of a Specification, of Ceilings or of a PsdOfFocus.
template <typename Answer>
nlohmann::ordered_json answer_json(const Answer& answer, const Study& study, const RunOptions& options) {
  return to_json(answer, resolved_study(study), provenance_of(study, options));
}

void require_block(const Study& study) {
  if (!study.solve)
    throw InputError(study.path, "/solve", kMissing,
                     "`aberfit solve` needs a block such as \"solve\": {\"for\": [\"/roughness/psd/rms\"], "
                     "\"so_that\": {\"ee80_diameter\": \"<= "
                     "0.6 arcsec\"}}; `aberfit new budget` writes such a study");
}

// Writes the pictures, the table and the document that all answers have.
template <typename Answer>
void write_answer(const Answer& answer, const Study& study, const RunOptions& options, const std::string& to,
                  std::vector<DrawnPicture> drawn) {
  write_result(to, options,
               {page_of(answer), answer_json(answer, study, options), typed_study(study), std::move(drawn)});
}

// Only generalised Harvey-Shack theory can include the path, because the transfer functions of its parts
// multiply. Geometric theory would need the variance of slopes, which turbulence does not have.
void require_light_of_path(const Study& study) {
  const Theory theory = theory_of_targets(study, RadialPsd(*study.psd));
  if (theory != Theory::kGhs)
    throw FieldError("target.theory", to_string(theory), "\"auto\" or \"ghs\" with solve.with");
}

// The part of a sum that a number belongs to: its name, or "part 2". A part of a part is "part 2 of part 1".
std::string part_of(const Study& study, const std::string& pointer) {
  std::string part;
  const RoughnessModel* node = study.roughness ? &*study.roughness : nullptr;
  const std::string step = "/parts/";
  for (std::size_t at = pointer.find(step); node && at != std::string::npos;
       at = pointer.find(step, at + 1)) {
    const auto* sum = std::get_if<RoughnessSum>(&node->model);
    const std::size_t k = std::stoul(pointer.substr(at + step.size()));
    node = sum && k < sum->parts.size() ? &sum->parts[k] : nullptr;
    if (!node) break;
    part = (node->name.empty() ? fmt::format("part {}", k + 1) : node->name) +
           (part.empty() ? "" : " of " + part);
  }
  return part;
}

// The mirror of the study together with all that blurs its focus.
TaskAt together_with_others(const Study& study, const Contributors& others) {
  const StudyFamily own(study, study.solve->unknowns);
  return others.empty() ? TaskAt(own) : with_contributors(own, others, study.solve->budgets);
}

// The same, until the run is asked to stop.
TaskAt until_stopped(TaskAt task_at, const RunContext& context) {
  return [task_at = std::move(task_at), context](const std::vector<double>& at) {
    context.stop_if_asked();
    return task_at(at);
  };
}

Contributors others_of(const Study& study) {
  return study.solve->with ? contributors(*study.solve->with) : Contributors{};
}

ResultClaim claim_of_solve(const Study& study, const RunOptions& options) {
  return claim_of("solve", options, {"contour.csv"}, wanted_pictures(options, &study),
                  {"contour", "budget_light", "sensitivities"});
}

void write(const Study& study, const RunOptions& options, ResultFolder* folder, Specification* spec) {
  if (!folder->wanted()) return;
  const std::string to = folder->path();
  const int threads = context_of(options).threads;
  std::vector<DrawnPicture> drawn;
  if (const PictureOptions pictures = wanted_pictures(options, &study);
      pictures.format != PictureFormat::kNone)
    drawn = draw_pictures(*spec, budget_light(together_with_others(study, others_of(study)), *spec, threads),
                          to, pictures, &spec->warnings);
  if (!spec->contour.points.empty()) write_file(to + "/contour.csv", contour_csv(*spec));
  write_answer(*spec, study, options, to, std::move(drawn));
  folder->show();
}

ResultClaim claim_of_ceilings(const Study& study, const RunOptions& options) {
  return claim_of("solve", options, {"ceilings.csv"}, wanted_pictures(options, &study), {"ceilings"});
}

void write(const Study& study, const RunOptions& options, ResultFolder* folder, Ceilings* ceilings) {
  if (!folder->wanted()) return;
  const std::string to = folder->path();
  auto drawn = draw_pictures(*ceilings, to, wanted_pictures(options, &study), &ceilings->warnings);
  if (ceilings->reason.empty()) write_file(to + "/ceilings.csv", ceilings_csv(*ceilings));
  write_answer(*ceilings, study, options, to, std::move(drawn));
  folder->show();
}

}  // namespace

std::vector<SolveUnknown> internal::solve_unknowns(const Study& study) {
  if (!study.psd)
    throw InputError(study.path, "/roughness", kMissing,
                     "`aberfit solve` needs a roughness block with the numbers to solve for");
  const std::vector<PsdNumber> numbers = psd_numbers(study);
  std::vector<std::string> known;
  for (const PsdNumber& number : numbers) known.push_back(number.pointer);
  std::vector<SolveUnknown> unknowns;
  for (std::size_t k = 0; k < study.solve->unknowns.size(); ++k) {
    const std::string& pointer = study.solve->unknowns[k];
    const auto at = std::find(known.begin(), known.end(), pointer);
    if (at == known.end())
      throw InputError(study.path, fmt::format("/solve/for/{}", k), '"' + pointer + '"',
                       known.empty()
                           ? "a roughness with numbers, such as the model that `aberfit psd` finds, instead "
                             "of \"measured\""
                           : fmt::format("a number of the study's roughness: {}", fmt::join(known, ", ")));
    const PsdNumber& number = numbers[std::size_t(at - known.begin())];
    unknowns.push_back({number.pointer, number.value, number.dimension, part_of(study, number.pointer)});
  }
  return unknowns;
}

Specification run_solve(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  require_block(study);
  if (study.solve->budgets.empty())
    throw InputError(
        study.path, "/solve/so_that", kMissing,
        "the command needs budgets that have to hold; a measured focus works only with `aberfit solve`");
  if (study.solve->unknowns.empty())
    throw InputError(
        study.path, "/solve/for", kMissing,
        "the command needs one or two numbers of the roughness; ceilings work only with `aberfit solve`");
  const std::vector<SolveUnknown> unknowns = solve_unknowns(study);
  ResultFolder folder(options.output_directory, claim_of_solve(study, options));
  const RunContext context = context_of(options);
  if (options.progress) options.progress("solving");
  SolveOptions how;
  how.contour_decades = study.solve->contour_decades;
  how.confidence = study.solve->confidence.value_or(0);
  const StudyFamily own(study, study.solve->unknowns);
  const Contributors others = others_of(study);
  const TaskAt together =
      with_fields_of(study, [&] { return until_stopped(together_with_others(study, others), context); });
  Specification spec = with_fields_of(study, [&] {
    if (!others.empty()) require_light_of_path(study);
    Specification whole = solve_specification(together, unknowns, study.solve->budgets, how, context);
    if (!others.empty() && whole.status == SolveStatus::kSolved)
      whole.uses = uses_of_budget(own(whole.solutions.front().at), others, whole.budgets, context.threads);
    if (!others.empty() && whole.status == SolveStatus::kNoSolution)
      whole.reason +=
          " The contributors in `with` are a part of each value, also where the mirror is smooth.";
    return whole;
  });
  spec.title = study.title;
  spec.warnings.insert(spec.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  write(study, options, &folder, &spec);
  return spec;
}

Ceilings run_ceilings(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  require_block(study);
  if (!study.solve->ceilings)
    throw InputError(study.path, "/solve/ceilings", kMissing,
                     "the command needs an object, e.g. {} or {\"f_max\": \"1 /mm\"}");
  ResultFolder folder(options.output_directory, claim_of_ceilings(study, options));
  const RunContext context = context_of(options);
  if (options.progress) options.progress("ceilings");
  Ceilings ceilings = with_fields_of(
      study, [&] { return find_ceilings(study, *study.solve->ceilings, study.solve->budgets, context); });
  ceilings.title = study.title;
  ceilings.warnings.insert(ceilings.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  write(study, options, &folder, &ceilings);
  return ceilings;
}

Answer internal::answer_solve(const SharedStudy& study, const RunOptions& options) {
  const auto code = [](bool found) { return found ? ExitCode::kDone : ExitCode::kNotMet; };
  if (study->solve && study->solve->ceilings) {
    const Ceilings ceilings = run_ceilings(*study, options);
    return answer_of(ceilings, code(ceilings.reason.empty()), study, options, claim_of_ceilings, write);
  }
  if (study->solve && study->solve->focus) {
    const PsdOfFocus found = run_psd_of_focus(*study, options);
    return answer_of(found, code(found.status == PsdOfFocusStatus::kFitted), study, options, claim_of_focus,
                     write_focus);
  }
  const Specification spec = run_solve(*study, options);
  return answer_of(spec, code(spec.status == SolveStatus::kSolved), study, options, claim_of_solve, write);
}

ExitCode solve_command(CommandLine line) { return study_command(std::move(line), StudyCommand::kSolve); }

}  // namespace aberfit
