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

// What of a JudgedSet was looked at, at these places, goes into what is known of it.
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

// Twice the noise of the wide circles among these targets, which all grids share, goes into their error. A
// width has the relative error of the half of the light that it ends at, twice over.
void add_noise_of_wide_circles(const FitCase& of, const JudgedSet& judged,
                               const std::vector<std::size_t>& among, double wide, FreshStatistics* fresh) {
  if (!std::isfinite(wide)) return;
  const std::vector<Target>& targets = judged.targets();
  const Eigen::VectorXd values = judged.judged(fresh->value);
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(values.size());
  for (const std::size_t target : among) {
    const auto k = Eigen::Index(target);
    const Target aim = aim_of(targets[target]);
    const auto* circle = std::get_if<RingThrough>(&aim.statistic);
    const bool width = std::holds_alternative<RingFwhm>(aim.statistic);
    const double angle = circle  ? circle->ring_radius / (of.task.mirror.focal_length + circle->dz)
                         : width ? wide
                                 : 0;
    if (angle >= wide)
      noise[k] = 2 * kWideCircleNoise * std::pow(grains_of(of.task, angle), -1.5) *
                 (width ? 2 * std::abs(values[k]) : aim.relative_to());
  }
  judged.add_to_judged(noise, &fresh->standard_error);
}

// How closely waves look; rays look once.
struct Look {
  double coarsening = 1;   // of the grid, over the safe pitch
  double wide = HUGE_VAL;  // angle from which on circles are wide [rad]

  bool is_closest() const { return coarsening <= 1 && !std::isfinite(wide); }
  Look closer() const { return coarsening > 1 ? Look{1, wide} : Look{}; }
};

// On a grid of law::kCellsOfALook across where the safe one has more, up to twice as coarse, but finer than
// the fit's.
Look first_look(const FitCase& of, const Attempt& attempt) {
  if (attempt.bench->model != FocusModel::kWaves) return {};
  const double safe = grid_pitch(of, attempt.result.terms, 1);
  const double affordable = 2 * of.ground.radius / (law::kCellsOfALook * safe);
  const double finer = attempt.bench->pitch / (std::numbers::sqrt2 * safe);
  return {std::max(1.0, std::min({affordable, finer, 2.0})), wide_circles(of.task, of.ground, of.targets)};
}

// Looks at these targets of `judged` and brings what is known of the attempt up to date.
void look_at(const FitCase& of, const JudgedSet& judged, const std::vector<std::size_t>& open,
             const Look& look, std::int64_t rays, Attempt* attempt) {
  const FitOutcome& result = attempt->result;
  const FreshPupil pupil{attempt->bench->model,
                         rays,
                         of.task.trace.pupil.seed,
                         grid_pitch(of, result.terms, look.coarsening),
                         look.wide,
                         judged_in_single_precision(look.wide, of.targets),
                         look.coarsening > 1};
  const std::vector<Eigen::Index> places = judged.places_of(open);
  std::vector<Statistic> asked;
  for (const Eigen::Index at : places) asked.push_back(judged.statistics()[std::size_t(at)]);
  attempt->fresh_warnings.clear();
  const FreshStatistics part =
      statistics_with_error(lit_mirror(of.task, of.ground.split), pupil, result.terms,
                            result.fit.coefficients, asked, of.context.threads, &attempt->fresh_warnings);
  take_over(part, places, &attempt->fresh);
  add_noise_of_wide_circles(of, judged, open, look.wide, &attempt->fresh);
  Eigen::VectorXd& first = attempt->first_seen;
  if (first.size() > 0) {
    first = first.array().isNaN().select(attempt->fresh.value, first);
  } else if (part.value.array().isFinite().any()) {
    first = attempt->fresh.value;
    attempt->judging_coarsening = look.coarsening;
  }
}

}  // namespace

void judge_on_fresh_rays(const FitCase& of, Attempt* attempt, std::int64_t rays) {
  of.context.say("fresh rays");
  FitOutcome& result = attempt->result;
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  if (rays == 0) rays = 4 * result.rays;
  const auto size = Eigen::Index(judged.statistics().size());
  attempt->fresh.value = attempt->fresh.standard_error = Eigen::VectorXd::Constant(size, std::nan(""));
  std::vector<std::size_t> open(judged.targets().size());
  std::iota(open.begin(), open.end(), std::size_t(0));
  attempt->first_seen = {};
  // What the error of a coarse grid leaves open goes to the safe one, and what the noise of wide circles
  // leaves open is looked at without them.
  for (Look look = first_look(of, *attempt);; look = look.closer()) {
    look_at(of, judged, open, look, rays, attempt);
    result.metrics = judged.judge(attempt->fresh, of.task.equivalence);
    const bool decided = attempt->fresh.value.allFinite() && attempt->fresh.standard_error.allFinite() &&
                         overall(result.metrics) != Verdict::kUndecided;
    if (decided || look.is_closest() || (of.context.stopped() && attempt->first_seen.size() > 0)) break;
    open = judged.open_targets(attempt->fresh, result.metrics);
  }
  if (attempt->first_seen.size() == 0) attempt->first_seen = attempt->fresh.value;
  result.validated = attempt->fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  result.verdict = overall(result.metrics);
}

}  // namespace aberfit
