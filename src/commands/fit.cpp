#include <memory>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/conclude.h"
#include "aberfit/method/fit_as_asked.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "analytic_normals.h"
#include "answers.h"
#include "fit_files.h"
#include "interrupt.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"
#include "unused_parts.h"

namespace aberfit {
using namespace internal;

namespace {

// One pass through the method. It owns everything that its parts refer to.
struct Run {
  Run(SharedStudy given, const PhysicsRequest& asked, const RunContext& how)
      : study(std::move(given)),
        context(how),
        layout((context.say("targets"), lay_out(*study, asked, context.threads))),
        of{*study, layout.ground, layout.targets, context} {}
  SharedStudy study;
  RunContext context;
  Layout layout;
  FitCase of;
};

// Rays suit the specification, but wave optics rejects the surface that they gave.
bool rays_fell_short(const FitCase& of, const FitOutcome& result) {
  return of.ground.use.model == FocusModel::kRays && of.ground.use.light_decides && !of.task.trace.model &&
         result.judgement.light && result.judgement.light->obstacle.empty() &&
         result.judgement.light->verdict != Verdict::kEquivalent &&
         overall(result.judgement.metrics) == Verdict::kEquivalent;
}

// Repeats the whole fit by waves. The result by rays is kept if that is interrupted.
Attempt fit_by_waves(Attempt by_rays, std::shared_ptr<const Run>* run) {
  const RunContext& context = (*run)->context;
  const SharedStudy& study = (*run)->study;
  context.say("rays are not enough; repeating with waves");
  try {
    auto waves =
        std::make_shared<const Run>(study, PhysicsRequest{study->target.theory, FocusModel::kWaves}, context);
    Attempt attempt = fit_as_asked(waves->of);
    if (context.stopped()) return by_rays;
    conclude(waves->of, &attempt);
    *run = std::move(waves);
    return attempt;
  } catch (const Interrupted&) {
    return by_rays;
  }
}

void note_interruption(const RunOptions& options, FitOutcome* result) {
  result->interrupted = true;
  result->stopped_by = options.stopped_by ? options.stopped_by() : "a signal";
  result->warnings.push_back(
      {"interrupted",
       "stopped by " + result->stopped_by + "; this is the best result so far, not that of a complete run"});
}

ResultDocument document(const Study& study, FitOutcome outcome, const RunOptions& options) {
  ResultDocument result;
  static_cast<FitOutcome&>(result) = std::move(outcome);
  result.title = study.title;
  result.provenance = provenance_of(study, options);
  return result;
}

FinishedFit fit_study(const SharedStudy& study, const RunOptions& options) {
  return with_fields_of(*study, [&] {
    require_analytic_normals(*study);
    if (study->map) throw FieldError("target.map", "a map as target", "statistics; run_map_fit is for maps");
    ResultFolder folder(options.output_directory, claim_of_fit(*study, options));
    auto run = std::make_shared<const Run>(study, requested_physics(*study), context_of(options));
    const RunContext& context = run->context;
    Attempt attempt = fit_as_asked(run->of);
    conclude(run->of, &attempt);
    if (rays_fell_short(run->of, attempt.result) && !context.stopped())
      attempt = fit_by_waves(std::move(attempt), &run);
    if (context.stopped()) note_interruption(options, &attempt.result);
    FinishedFit fit{study, document(*study, std::move(attempt.result), options), run->layout.ground,
                    [bench = attempt.bench] { return bench; }};
    const Warnings unused = unused_parts(*study, "`aberfit solve`");
    fit.result.warnings.insert(fit.result.warnings.end(), unused.begin(), unused.end());
    write_fit(options, &folder, &fit);
    return fit;
  });
}

}  // namespace

RunContext context_of(const RunOptions& options) {
  return {options.threads > 0 ? options.threads : available_threads(), options.progress, options.interrupted};
}

ResultDocument run_fit(const Study& study, const RunOptions& options) {
  return fit_study(std::make_shared<const Study>(completed(study)), options).result;
}

ExitCode internal::code_of_fit(const ResultDocument& result) {
  if (result.fitted.fit.status == FitStatus::kFailed) return ExitCode::kComputationFailed;
  if (result.interrupted) return ExitCode::kInterrupted;
  // Without a specification a map cannot be judged, so only convergence counts.
  const bool done = result.map.fit && !result.has_roughness
                        ? result.fitted.fit.status == FitStatus::kConverged
                        : result.judgement.verdict == Verdict::kEquivalent;
  return done ? ExitCode::kDone : ExitCode::kNotMet;
}

Answer internal::answer_fit(const SharedStudy& study, const RunOptions& options) {
  return answer_of(fit_study(study, options));
}

ExitCode fit_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "fit");
  ProgressLine progress(!line.quiet);
  const Interrupt interrupt;
  const TimeLimit limit(line.time_limit);
  RunOptions options = run_options(line, &progress);
  options.interrupted = [&] { return interrupt.asked() || limit.over(); };
  options.stopped_by = [&] { return interrupt.asked() ? "a signal" : limit.text(); };
  const Answer found = answer(StudyCommand::kFit, study, options);
  progress.clear();
  return show(line, found, found.code != ExitCode::kComputationFailed);
}

}  // namespace aberfit
