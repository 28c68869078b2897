#include "aberfit/method/fewest_terms.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "aberfit/core/random.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/term_search.h"

namespace aberfit {
namespace {

FrontierPoint frontier_point(const Attempt& attempt, double seconds) {
  FrontierPoint point;
  point.terms = attempt.result.terms.size();
  point.rays = attempt.result.rays;
  point.fitted_mismatch = attempt.mismatch;
  point.seconds = seconds;
  if (attempt.fresh.rays == 0) return point;
  point.verdict = attempt.result.verdict;
  point.passes = attempt.met && attempt.result.verdict == Verdict::kEquivalent;
  double worst = NAN;
  for (const EquivalenceMetric& metric : attempt.result.metrics)
    if (metric.held_out) worst = std::fmax(worst, std::abs(metric.relative_difference));
  point.held_out_mismatch = worst;
  return point;
}

// White coordinates of `terms` that continue a fit of fewer Zernikes: its coefficients, and the seeded draw's
// for the new orders.
Eigen::VectorXd continued(const Study& study, const Attempt& before, const TermSet& terms,
                          const CoefficientPrior& prior) {
  Eigen::VectorXd coefficients = prior.colour(draw_white(prior.size(), study.fit.seed));
  const Eigen::Index n = std::min(before.result.fit.coefficients.size(), Eigen::Index(terms.zernike.size()));
  coefficients.head(n) = before.result.fit.coefficients.head(n);
  return prior.whiten(coefficients);
}

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// Fits one set after the other, each started from what the ones before it left.
class Trials {
 public:
  Trials(const Study& study, const Scene& scene, const TargetSets& targets, const RunOptions& options,
         int threads)
      : study_(study), scene_(scene), targets_(targets), options_(options), threads_(threads) {}

  // A short fit on few rays, continuing the last one with fewer terms.
  FrontierPoint screen(const Study& with) {
    const auto begin = Clock::now();
    Study cheap = with;
    double captured = 0;
    const TermSet terms = make_terms(cheap, scene_, &captured);
    if (ends_below_the_spectrum(with)) {
      FrontierPoint point;
      point.terms = terms.size();
      point.fitted_mismatch = HUGE_VAL;
      point.screened = true;
      return point;
    }
    cheap.trace.pupil.rays = screening_rays(terms.size());
    cheap.fit.starts = 1;
    Effort effort;
    effort.most_iterations = kScreeningIterations;
    if (screened_ && screened_->result.terms.size() < terms.size())
      effort.warm = continued(study_, *screened_, terms, make_study_prior(cheap, scene_, terms));
    Attempt attempt = attempt_fit(cheap, scene_, targets_, options_, effort, threads_);
    FrontierPoint point = frontier_point(attempt, since(begin));
    point.screened = true;
    if (has_solution(attempt.result.fit)) screened_ = std::move(attempt);
    return point;
  }

  // The whole fit; a descent continues the last one that passed.
  FrontierPoint confirm(const Study& with, bool descending) {
    const auto begin = Clock::now();
    Effort effort;
    effort.give_up_on_stall = true;
    if (descending && best_) {
      double captured = 0;
      const TermSet terms = make_terms(with, scene_, &captured);
      effort.warm = continued(study_, *best_, terms, make_study_prior(with, scene_, terms));
    }
    Attempt attempt = fit_on_enough_rays(with, scene_, targets_, options_, effort, false, threads_);
    const FrontierPoint point = frontier_point(attempt, since(begin));
    if (point.passes && (!best_ || point.terms < best_->result.terms.size())) best_ = std::move(attempt);
    return point;
  }

  // The fewest that passed, if any did. Other fits are not kept.
  std::optional<Attempt>& best() { return best_; }

 private:
  // Terms that end below the PSD bins that are asked for have no power there.
  bool ends_below_the_spectrum(const Study& with) const {
    return study_.target.psd && with.terms.zernike &&
           (with.terms.zernike->n_max.value() + 1) / (2 * EIGEN_PI * scene_.radius) <=
               study_.target.psd->f_min.value_or(scene_.psd->f_min());
  }

  const Study& study_;
  const Scene& scene_;
  const TargetSets& targets_;
  const RunOptions& options_;
  int threads_;
  std::optional<Attempt> screened_, best_;
};

}  // namespace

Attempt fit_fewest_terms(const Study& study, const Scene& scene, const TargetSets& targets,
                         const RunOptions& options, int threads) {
  Trials trials(study, scene, targets, options, threads);
  // Short fits say nothing of waves: where they end, the next one stays trapped.
  const bool descend = scene.use.model == FocusModel::kWaves;
  const OrderRange range = expected_orders(scene);
  TermTrials hooks;
  if (!descend) hooks.screen = [&](const Study& with) { return trials.screen(with); };
  hooks.confirm = [&](const Study& with) { return trials.confirm(with, descend); };
  Frontier frontier = search_terms(study, range, hooks);
  std::optional<Attempt> best = std::move(trials.best());
  if (!best) {
    // None passed, so none was kept; the nearest is fitted as if it had been asked for, to the end.
    const auto begin = Clock::now();
    const auto chosen = std::find_if(frontier.points.begin(), frontier.points.end(),
                                     [](const FrontierPoint& point) { return point.chosen; });
    best = fit_on_enough_rays(chosen->family == "fourier" ? with_fourier_modes(study, chosen->order)
                                                          : with_zernikes(study, chosen->order),
                              scene, targets, options, {}, true, threads);
    FrontierPoint point = frontier_point(*best, chosen->seconds + since(begin));
    point.family = chosen->family;
    point.order = chosen->order;
    point.chosen = true;
    *chosen = point;
    frontier.seconds += since(begin);
    frontier.message = search_message(frontier, range);
  } else {
    // The band and the frontier say what a set of fewest terms leaves out; more terms are not called for.
    std::erase_if(best->result.warnings, [](const Warning& w) { return w.code == "truncated-terms"; });
  }
  best->result.frontier = frontier;
  return std::move(*best);
}

}  // namespace aberfit
