#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "aberfit/cases/gather.h"
#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/read_study.h"
#include "case_work.h"
#include "interrupt.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"
#include "unused_parts.h"

namespace aberfit {
using namespace internal;

namespace {

// Number of cases that a rank gets at once. Short cases come in groups, because asking for one takes as long.
std::size_t longest_run(CaseLevel level) { return level == CaseLevel::kCheck ? 32 : 1; }

// Shows the progress of many threads on one line, a few times a second.
class SweepProgress {
 public:
  SweepProgress(const RunOptions& options, std::size_t known, std::size_t left)
      : show_(options.progress), known_(known), left_(left) {}
  // handed_out: number of cases given to this process and others.
  void tell(std::size_t handed_out) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (!show_ || now - shown_ < std::chrono::milliseconds(250)) return;
    shown_ = now;
    const std::string known =
        known_ > 0 ? fmt::format("; {} known from earlier runs", grouped(double(known_))) : "";
    show_(progress_text(handed_out, left_, 0, std::chrono::duration<double>(now - begin_).count()) + known);
  }

 private:
  const std::function<void(const std::string&)>& show_;
  std::size_t known_, left_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now(), shown_ = begin_;
};

struct Sweep {
  const StudyCases& cases;
  CasePlan plan;
  std::string folder;  // of the records
  KnownCases known;
  Warnings warnings;

  Sweep(const StudyCases& all, const std::string& output)
      : cases(all),
        plan(*all.study().vary, all.study().fit.seed, all.study().path),
        folder(output + "/cases") {}
  void read_records(bool but_failed) {
    std::size_t damaged = 0;
    std::vector<CaseRecord> records = read_journals(folder, &damaged);
    if (but_failed) std::erase_if(records, [](const CaseRecord& record) { return !record.error.empty(); });
    known = KnownCases(std::move(records));
    warnings.clear();
    if (damaged > 0)
      warnings.push_back(
          {"damaged-records",
           fmt::format("{} lines in files of {} are not records and were ignored; their cases are run again",
                       damaged, folder)});
  }
};

// Runs this process' part of the cases. Rank 0 of several also hands cases to the others on request.
void run_part(const Sweep& sweep, Team* team, LocalQueue* queue, const RunOptions& options) {
  const Study& study = sweep.cases.study();
  RunContext context = context_of(options);
  if (team && options.threads <= 0) context.threads = 1;  // assume one rank for every processor
  SweepProgress progress(options, sweep.plan.size() - queue->size(), queue->size());
  context.progress = [&](const std::string&) { progress.tell(queue->handed_out()); };
  CaseJournal journal(sweep.folder);
  const CaseWork work = case_work(study.vary->run, options.interrupted);
  const auto run = [&](CaseQueue* from) {
    return run_cases(sweep.cases, sweep.plan, sweep.known, work, from, &journal, context);
  };
  if (!team) {
    run(queue);
  } else if (team->rank() > 0) {
    context.progress = {};
    const auto from_first = team->queue();
    run(from_first.get());
    team->leave();
  } else {
    std::exception_ptr problem;
    std::thread own([&] {
      try {
        run(queue);
      } catch (...) {
        problem = std::current_exception();
        queue->close();
      }
    });
    team->serve(queue, longest_run(study.vary->run), [&] {
      if (context.stopped()) queue->close();
      progress.tell(queue->handed_out());
    });
    own.join();
    if (problem) std::rethrow_exception(problem);
  }
}

nlohmann::ordered_json sweep_json(const SweepReport& report, const Study& study, const RunOptions& options) {
  return to_json(report, resolved_study(study), provenance_of(study, options));
}

ResultClaim claim_of_sweep(const Study& study, const RunOptions& options) {
  return claim_of("sweep", options, {"cases.csv", "quantiles.csv"}, wanted_pictures(options, &study),
                  {"curve_", "map_", "contour_"});
}

// We check the folder before a case runs: records must be a sweep's, and results must not replace other
// files.
void require_own_folder(const Sweep& sweep, const RunOptions& options) {
  ResultFolder::look(options.output_directory, claim_of_sweep(sweep.cases.study(), options));
  if (const std::string file = foreign_journal(sweep.folder); !file.empty())
    throw InputError(file, "", "a folder without records of a sweep", "another folder with --output");
}

SweepReport gather(Sweep* sweep, const RunOptions& options) {
  const GatherLock lock(sweep->folder);
  sweep->read_records(false);
  SweepReport report = gather_cases(sweep->cases, sweep->plan, sweep->known);
  const Study& study = sweep->cases.study();
  if (study.vary->run != CaseLevel::kSolve)
    for (Warning& unused : unused_parts(study, "`\"run\": \"solve\"` in `vary`"))
      sweep->warnings.push_back(std::move(unused));
  report.warnings.insert(report.warnings.end(), sweep->warnings.begin(), sweep->warnings.end());
  ResultFolder folder(options.output_directory, claim_of_sweep(study, options));
  const std::string to = folder.path();
  auto drawn = draw_pictures(report, to, wanted_pictures(options, &study), &report.warnings);
  write_file(to + "/cases.csv", cases_csv(report));
  if (report.has_seeds) write_file(to + "/quantiles.csv", quantiles_csv(report));
  write_result(to, options,
               {page_of(report), sweep_json(report, study, options), typed_study(study), std::move(drawn)});
  folder.show();
  return report;
}

}  // namespace

std::optional<SweepReport> run_sweep(const StudyCases& cases, const RunOptions& options,
                                     const SweepOptions& how) {
  Sweep sweep(cases, options.output_directory);
  require_own_folder(sweep, options);
  Shard shard = read_shard(how.shard, environment_variable);
  if (how.gather_only) return gather(&sweep, options);
  check_pointers(cases, sweep.plan);
  const std::unique_ptr<Team> team = Team::join(environment_variable, &shard);
  try {
    if (team && team->rank() > 0) {
      LocalQueue nothing({});
      run_part(sweep, team.get(), &nothing, options);
      return std::nullopt;
    }
    {
      const ShareLock lock(sweep.folder, shard.index, shard.count);
      sweep.read_records(how.retry);
      LocalQueue queue(cases_left(cases, sweep.plan, sweep.known, shard));
      run_part(sweep, team.get(), &queue, options);
    }
    return gather(&sweep, options);
  } catch (const std::exception& error) {
    if (team) {
      fmt::print(stderr, "aberfit: {}\n", error.what());
      const bool is_input = dynamic_cast<const InputError*>(&error) != nullptr;
      team->abort(int(is_input ? ExitCode::kBadInput : ExitCode::kComputationFailed));
    }
    throw;
  }
}

ExitCode sweep_command(CommandLine line) {
  const StudyCases cases = StudyCases::read(line.study_file, line.changes);
  choose_output_directory(&line, "sweep");
  ProgressLine progress(!line.quiet);
  const Interrupt interrupt;
  const TimeLimit limit(line.time_limit);
  std::atomic<bool> ended{false};  // true if stopped before all cases were handed out
  RunOptions options = run_options(line, &progress);
  options.interrupted = [&] {
    const bool end = interrupt.asked() || limit.over();
    if (end) ended = true;
    return end;
  };
  const std::optional<SweepReport> report =
      run_sweep(cases, options, {line.shard, line.gather_only, line.retry_failed});
  progress.clear();
  if (!report) return ExitCode::kDone;
  print(
      line, [&] { return sweep_json(*report, cases.study(), options); }, page_of(*report));
  say_where(line);
  if (ended && !report->is_complete()) return ExitCode::kInterrupted;
  return report->failed() > 0 ? ExitCode::kNotMet : ExitCode::kDone;
}

}  // namespace aberfit
