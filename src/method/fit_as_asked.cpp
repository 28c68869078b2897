#include "aberfit/method/fit_as_asked.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/method/all_scatter.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/plan.h"

namespace aberfit {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

FrontierPoint frontier_point(const Attempt& attempt, double seconds) {
  const TermSet& terms = attempt.result.fitted.terms;
  FrontierPoint point;
  point.family = terms.zernike.empty() ? "fourier" : "zernike";
  point.order = terms.zernike.empty() ? int(terms.fourier.size()) : terms.zernike.back().n;
  point.terms = terms.size();
  point.rays = attempt.result.fitted.rays;
  point.fitted_mismatch = attempt.mismatch;
  point.seconds = seconds;
  if (attempt.fresh.rays == 0) return point;
  point.verdict = attempt.result.judgement.verdict;
  point.passes = is_equivalent(attempt);
  for (const EquivalenceMetric& metric : attempt.result.judgement.metrics)
    if (metric.held_out)
      point.held_out_mismatch = std::fmax(point.held_out_mismatch, std::abs(metric.difference));
  return point;
}

// The sets of a run in the order of their fits, and the set that is kept.
class Sets {
 public:
  // most: largest number of sets; 0: unknown.
  Sets(const FitCase& of, int most) : of_(of), most_(most) {}

  // Fits these terms from the task's number of starts; true when one fit is equivalent.
  bool pass(const TermsSpec& asked) {
    const auto begin = Clock::now();
    of_.context.say("covariance of the terms");
    const auto terms = std::make_shared<const TermPlan>(plan_terms(of_.task, of_.ground, asked));
    FitPlan plan = make_plan(of_.task, terms);
    plan.set = int(points_.size()) + 1;
    plan.most_sets = most_;
    std::optional<Attempt> best;
    for (; plan.start < of_.task.fit.starts; ++plan.start) {
      Attempt attempt = fit_on_a_fine_enough_sample(of_, plan);
      if (!best || distance_to_margin(attempt) < distance_to_margin(*best)) best = std::move(attempt);
      best->result.choices.values.starts = plan.start + 1;
      if (is_equivalent(*best) || of_.context.stopped()) break;
    }
    points_.push_back(frontier_point(*best, since(begin)));
    const bool passes = points_.back().passes;
    if (is_kept(*best)) kept_ = std::move(*best), kept_point_ = points_.size() - 1;
    return passes;
  }

  const Attempt& kept() const { return *kept_; }
  Attempt take() { return std::move(*kept_); }
  Attempt finish(bool fewest, std::string message) {
    Frontier frontier;
    frontier.fewest = fewest;
    frontier.margin = of_.task.equivalence.margin;
    frontier.message = std::move(message);
    points_[kept_point_].chosen = true;
    for (const FrontierPoint& point : points_) frontier.seconds += point.seconds;
    frontier.points = std::move(points_);
    std::stable_sort(frontier.points.begin(), frontier.points.end(),
                     [](const FrontierPoint& a, const FrontierPoint& b) { return a.terms < b.terms; });
    kept_->result.choices.frontier = std::move(frontier);
    return take();
  }

 private:
  // The order of preference is: an equivalent set of fewer terms, any equivalent set, the nearest set.
  bool is_kept(const Attempt& now) const {
    if (!kept_) return true;
    if (is_equivalent(now) != is_equivalent(*kept_)) return is_equivalent(now);
    return is_equivalent(now) ? now.result.fitted.terms.size() < kept_->result.fitted.terms.size()
                              : distance_to_margin(now) < distance_to_margin(*kept_);
  }

  const FitCase& of_;
  int most_;
  std::vector<FrontierPoint> points_;
  std::optional<Attempt> kept_;
  std::size_t kept_point_ = 0;
};

std::string set_of(const Attempt& attempt) {
  const TermSet& terms = attempt.result.fitted.terms;
  std::vector<std::string> families;
  if (!terms.zernike.empty()) families.push_back(fmt::format("Zernikes to n = {}", terms.zernike.back().n));
  if (!terms.fourier.empty()) families.push_back(fmt::format("{} plane waves", terms.fourier.size()));
  if (terms.of_a_segment() > 0)
    families.push_back(fmt::format("errors of {} segments", terms.segments->all().size()));
  return fmt::format("{} terms: {}", terms.size(), fmt::join(families, " and "));
}

// More terms help where a fitted or judged statistic is off, not where a verdict is undecided.
bool asks_for_more(const Attempt& attempt) {
  return attempt.result.judgement.verdict == Verdict::kDifferent ||
         attempt.result.fitted.fit.status != FitStatus::kConverged;
}

Attempt fit_by_law(const FitCase& of) {
  Sets sets(of, 1 + law::kMostGrowths);
  int tried = 0;
  double growth = 1;
  for (bool more = true; more && tried <= law::kMostGrowths; growth *= law::kGrowth) {
    const TermsSpec terms = terms_by_law(of.task, of.ground, growth);
    ++tried;
    more = !sets.pass(terms) && asks_for_more(sets.kept()) && terms.zernike && !of.context.stopped();
  }
  const std::string set = set_of(sets.kept());
  if (tried == 1) return sets.finish(false, set + ", as many as carry the band to its end");
  if (is_equivalent(sets.kept()))
    return sets.finish(false, fmt::format("{}. This is the last of {} sets that carry the band to its end "
                                          "and beyond. It is equivalent; its held-out statistics selected it",
                                          set, tried));
  return sets.finish(false, fmt::format("{}. None of {} sets that carry the band to its end and beyond is "
                                        "equivalent; this one is the nearest",
                                        set, tried));
}

TermsSpec zernikes_to(const Task& task, int order) {
  TermsSpec terms;
  terms.zernike.emplace(ZernikeSpec{std::min(1, order), order});
  terms.covariance = task.terms.covariance;
  return terms;
}

Attempt fit_fewest(const FitCase& of) {
  const TermsSpec all = terms_by_law(of.task, of.ground);
  Sets sets(of, 0);
  bool passes = sets.pass(all);
  if (!passes && all.zernike && !of.context.stopped())
    passes = sets.pass(terms_by_law(of.task, of.ground, law::kGrowth));
  int high = all.zernike ? sets.kept().result.fitted.terms.zernike.back().n : law::kLargestOrder, low = 1;
  while (passes && high > std::ceil(law::kFewestWithin * low) && !of.context.stopped()) {
    const int middle = std::clamp(int(std::lround(std::sqrt(double(low) * high))), low + 1, high - 1);
    (sets.pass(zernikes_to(of.task, middle)) ? high : low) = middle;
  }
  const std::string set = set_of(sets.kept());
  if (!passes)
    return sets.finish(
        true, fmt::format(
                  "{}. The set that carries the band is not equivalent, so fewer terms were not tried", set));
  return sets.finish(
      true,
      fmt::format(
          "{}. This is the smallest equivalent set, to {:.0f} % of the order. The held-out statistics "
          "selected it, so they are no independent check; its PSD need not be that of the specification",
          set, 100 * (law::kFewestWithin - 1)));
}

}  // namespace

TermsSpec terms_by_law(const Task& task, const Groundwork& ground, double growth) {
  const RadialPsd& band = *ground.term_psd;
  const double last = band_end(band);
  const int order = int(std::ceil(growth * order_to_carry(ground.radius, last)));
  if (order <= std::ceil(growth * law::kLargestOrder)) return zernikes_to(task, order);
  TermsSpec terms;
  const double across = 2 * ground.radius * last;
  terms.fourier.emplace().sampling =
      0.5 * kPi * across * across <= law::kMostWaves ? FourierSampling::kGrid : FourierSampling::kLog;
  return terms;
}

Attempt fit_as_asked(const FitCase& of) {
  if (of.ground.all_scatters()) return judge_all_scatter(of);
  if (of.task.terms.automatic() && of.ground.psd)
    return of.task.terms.fewest ? fit_fewest(of) : fit_by_law(of);
  Sets sets(of, 1);
  sets.pass(of.task.terms);
  return sets.take();
}

}  // namespace aberfit
