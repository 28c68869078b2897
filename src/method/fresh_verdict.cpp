#include "aberfit/method/fresh_verdict.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "fit_grids.h"

namespace aberfit {
using namespace internal;

namespace {

// Writes statistics at these places of a JudgedSet into the fresh statistics.
void take_over(const FreshStatistics& part, const std::vector<Eigen::Index>& places, FreshStatistics* fresh) {
  FreshStatistics all = part;
  all.value = std::move(fresh->value);
  all.standard_error = std::move(fresh->standard_error);
  for (std::size_t j = 0; j < places.size(); ++j) {
    all.value[places[j]] = part.value[Eigen::Index(j)];
    all.standard_error[places[j]] = part.standard_error[Eigen::Index(j)];
  }
  *fresh = std::move(all);
}

// The first judging grid has law::kCellsOfALook cells across where the safe one has more. It is at most twice
// as coarse as the safe grid, and finer than the fit's.
double first_coarsening(const FitCase& of, const Attempt& attempt) {
  if (attempt.bench->model != FocusModel::kWaves) return 1;
  const double safe = grid_pitch(of, attempt.result.fitted.terms, 1);
  const double affordable = 2 * of.ground.radius / (law::kCellsOfALook * safe);
  const double finer = attempt.bench->pitch / (std::numbers::sqrt2 * safe);
  return std::max(1.0, std::min({affordable, finer, 2.0}));
}

// Computes these targets of `judged` on a fresh sample and updates the attempt.
void look_at(const FitCase& of, const JudgedSet& judged, const std::vector<std::size_t>& open,
             double coarsening, std::int64_t rays, Attempt* attempt) {
  const FitOutcome& result = attempt->result;
  const FocusModel model = attempt->bench->model;
  const double pitch = grid_pitch(of, result.fitted.terms, coarsening);
  const FreshPupil pupil{model,
                         rays,
                         of.task.trace.pupil.seed,
                         pitch,
                         in_single_precision(model, of.targets, cells_of(of.task, pitch)),
                         coarsening > 1};
  const std::vector<Eigen::Index> places = judged.places_of(open);
  std::vector<Statistic> asked;
  for (const Eigen::Index at : places) asked.push_back(judged.statistics()[std::size_t(at)]);
  attempt->fresh_warnings.clear();
  const FreshStatistics part = statistics_with_error(lit_mirror(of.task, of.ground.split), pupil,
                                                     result.fitted.terms, result.fitted.fit.coefficients,
                                                     asked, of.context.threads, &attempt->fresh_warnings);
  take_over(part, places, &attempt->fresh);
  Eigen::VectorXd& first = attempt->first_seen;
  if (first.size() > 0) {
    first = first.array().isNaN().select(attempt->fresh.value, first);
  } else if (part.value.array().isFinite().any()) {
    first = attempt->fresh.value;
    attempt->judging_coarsening = coarsening;
  }
}

}  // namespace

void judge_on_fresh_rays(const FitCase& of, Attempt* attempt, std::int64_t rays) {
  of.context.say("judging on fresh rays");
  FitOutcome& result = attempt->result;
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  if (rays == 0) rays = 4 * result.fitted.rays;
  const auto size = Eigen::Index(judged.statistics().size());
  attempt->fresh.value = attempt->fresh.standard_error = Eigen::VectorXd::Constant(size, std::nan(""));
  std::vector<std::size_t> open(judged.targets().size());
  std::iota(open.begin(), open.end(), std::size_t(0));
  attempt->first_seen = {};
  // The safe grid decides statistics that the error of a coarse grid leaves undecided.
  for (double coarsening = first_coarsening(of, *attempt);; coarsening = 1) {
    look_at(of, judged, open, coarsening, rays, attempt);
    result.judgement.metrics = judged.judge(attempt->fresh, of.task.equivalence);
    const bool decided = attempt->fresh.value.allFinite() && attempt->fresh.standard_error.allFinite() &&
                         overall(result.judgement.metrics) != Verdict::kUndecided;
    if (decided || coarsening <= 1 || (of.context.stopped() && attempt->first_seen.size() > 0)) break;
    open = judged.open_targets(attempt->fresh, result.judgement.metrics);
  }
  if (attempt->first_seen.size() == 0) attempt->first_seen = attempt->fresh.value;
  result.fitted.validated = attempt->fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  result.judgement.verdict = overall(result.judgement.metrics);
}

}  // namespace aberfit
