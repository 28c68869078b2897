#include "aberfit/method/fresh_verdict.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

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

// Looks at these targets of `judged` and brings what is known of the attempt up to date.
void look_at(const FitCase& of, const JudgedSet& judged, const std::vector<std::size_t>& open, double wide,
             std::int64_t rays, Attempt* attempt) {
  const FitOutcome& result = attempt->result;
  const FreshPupil pupil{attempt->bench->model,           rays, of.task.trace.pupil.seed,
                         grid_pitch(of, result.terms, 1), wide, judged_in_single_precision(wide, of.targets)};
  const std::vector<Eigen::Index> places = judged.places_of(open);
  std::vector<Statistic> asked;
  for (const Eigen::Index at : places) asked.push_back(judged.statistics()[std::size_t(at)]);
  attempt->fresh_warnings.clear();
  const FreshStatistics part =
      statistics_with_error(lit_mirror(of.task, of.ground.split), pupil, result.terms,
                            result.fit.coefficients, asked, of.context.threads, &attempt->fresh_warnings);
  take_over(part, places, &attempt->fresh);
  add_noise_of_wide_circles(of, judged, open, wide, &attempt->fresh);
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
  // On the safe grid; what the noise of wide circles leaves open is looked at without them.
  const double wide = wide_circles(of.task, of.ground, of.targets);
  look_at(of, judged, open, wide, rays, attempt);
  attempt->first_seen = attempt->fresh.value;
  result.metrics = judged.judge(attempt->fresh, of.task.equivalence);
  const bool decided = attempt->fresh.value.allFinite() && attempt->fresh.standard_error.allFinite() &&
                       overall(result.metrics) != Verdict::kUndecided;
  if (!decided && std::isfinite(wide) && !of.context.stopped()) {
    open = judged.open_targets(attempt->fresh, result.metrics);
    look_at(of, judged, open, HUGE_VAL, rays, attempt);
    result.metrics = judged.judge(attempt->fresh, of.task.equivalence);
  }
  result.validated = attempt->fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  result.verdict = overall(result.metrics);
}

}  // namespace aberfit
