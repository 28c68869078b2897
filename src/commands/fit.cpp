#include "aberfit/commands/run.h"
#include "aberfit/core/parallel.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/conclude.h"
#include "aberfit/method/fewest_terms.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "analytic_normals.h"
#include "fit_files.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

Attempt fit_as_asked(const FitCase& of) {
  if (of.task.terms.automatic && of.ground.psd) return fit_fewest_terms(of);
  of.context.say("prior");
  const auto terms = std::make_shared<const TermPlan>(plan_terms(of.task, of.ground, of.task.terms));
  return fit_on_enough_rays(of, make_plan(of.task, terms), true);
}

ResultDocument document(const Study& study, FitOutcome outcome, int threads) {
  ResultDocument result;
  static_cast<FitOutcome&>(result) = std::move(outcome);
  result.title = study.title;
  result.provenance = make_provenance(study.fit.seed, threads);
  result.provenance.libraries["ceres"] = solver_version();
  return result;
}

}  // namespace

RunContext context_of(const RunOptions& options) {
  return {options.threads > 0 ? options.threads : available_threads(), options.progress};
}

ResultDocument run_fit(const Study& study, const RunOptions& options) {
  return with_fields_of(study, [&] {
    require_analytic_normals(study);
    if (study.map) throw FieldError("target.map", "a map as target", "statistics; run_map_fit is for maps");
    const RunContext context = context_of(options);
    const Groundwork ground = lay_groundwork(study);
    context.say("targets");
    const TargetSets targets = make_targets(study, ground, context.threads);
    const FitCase of{study, ground, targets, context};
    Attempt attempt = fit_as_asked(of);
    conclude(of, &attempt);
    ResultDocument result = document(study, std::move(attempt.result), context.threads);
    if (!options.output_directory.empty())
      write_fit(study, ground, options, attempt.bench->focus(study), &result);
    return result;
  });
}

ExitCode fit_command(CommandLine line) {
  const Study study = read_study(line.study_file);
  choose_output_directory(&line);
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const ResultDocument result = study.map ? run_map_fit(study, options) : run_fit(study, options);
  progress.clear();
  print(line, line.json ? to_json(result, resolved(study, result)) : nlohmann::ordered_json(),
        summary_table(result, false));
  say_where(line);
  if (result.fit.status == FitStatus::kFailed) return ExitCode::kComputationFailed;
  const bool judged_well = result.map.has_value() || result.verdict == Verdict::kEquivalent;
  const bool met = result.fit.status == FitStatus::kConverged && judged_well;
  return met ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
