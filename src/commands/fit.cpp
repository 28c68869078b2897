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
  Run(const Study& study, const PhysicsRequest& asked, const RunContext& context)
      : layout((context.say("targets"), lay_out(study, asked, context.threads))),
        of{study, layout.ground, layout.targets, context} {}
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
Attempt fit_by_waves(const Study& study, const RunContext& context, Attempt by_rays,
                     std::unique_ptr<Run>* run) {
  context.say("rays are not enough; repeating with waves");
  auto waves = std::make_unique<Run>(study, PhysicsRequest{study.target.theory, FocusModel::kWaves}, context);
  try {
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

}  // namespace

RunContext context_of(const RunOptions& options) {
  return {options.threads > 0 ? options.threads : available_threads(), options.progress, options.interrupted};
}

ResultDocument run_fit(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  return with_fields_of(study, [&] {
    require_analytic_normals(study);
    if (study.map) throw FieldError("target.map", "a map as target", "statistics; run_map_fit is for maps");
    ResultFolder folder(options.output_directory, claim_of_fit(study, options));
    const RunContext context = context_of(options);
    auto run = std::make_unique<Run>(study, requested_physics(study), context);
    Attempt attempt = fit_as_asked(run->of);
    conclude(run->of, &attempt);
    if (rays_fell_short(run->of, attempt.result) && !context.stopped())
      attempt = fit_by_waves(study, context, std::move(attempt), &run);
    if (context.stopped()) note_interruption(options, &attempt.result);
    ResultDocument result = document(study, std::move(attempt.result), options);
    const Warnings unused = unused_parts(study, "`aberfit solve`");
    result.warnings.insert(result.warnings.end(), unused.begin(), unused.end());
    if (!folder.wanted() || result.fitted.fit.status == FitStatus::kFailed) return result;
    RunOptions there = options;
    there.output_directory = folder.path();
    write_fit(study, run->layout.ground, there, attempt.bench->focus(study), &result);
    folder.show();
    return result;
  });
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
  const ResultDocument result = study.map ? run_map_fit(study, options) : run_fit(study, options);
  progress.clear();
  print(
      line, [&] { return to_json(result, resolved(study, result)); }, page_of(result, false));
  if (result.fitted.fit.status == FitStatus::kFailed) return ExitCode::kComputationFailed;
  say_where(line);
  if (result.interrupted) return ExitCode::kInterrupted;
  // Without a specification a map cannot be judged, so only convergence counts.
  const bool done = result.map.fit && !result.has_roughness
                        ? result.fitted.fit.status == FitStatus::kConverged
                        : result.judgement.verdict == Verdict::kEquivalent;
  return done ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
