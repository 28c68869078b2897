#pragma once
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit {

enum class Verdict { kEquivalent, kDifferent, kUndecided };
std::string to_string(Verdict verdict);

/// One statistic judged by two one-sided tests (TOST, Schuirmann 1987) on a difference: relative to the
/// target, of encircled-energy radii with a curve in light (PHYSICS 7): the fraction less the share of the
/// light inside the target's radius, over max(r dE/dr, kFlattestCurve), which where the curve is steep is the
/// radius's.
struct EquivalenceMetric {
  std::string name;
  bool held_out = false;
  double target = 0, model = 0;    ///< as shown, in the statistic's unit
  double relative_difference = 0;  ///< model/target - 1 of what is shown
  double difference = 0;           ///< what is judged, to be within +-margin
  double standard_error = 0;       ///< of `difference`
  double degrees_of_freedom =
      std::numeric_limits<double>::infinity();  ///< that the standard error is known by
  double interval[2] = {0, 0};    ///< confidence interval of it at level 2 confidence - 1 (90 % for 0.95)
  double margin = 0;              ///< relative
  double model_error = 0;         ///< bound of what the model itself is off by; `interval` includes it
  double share_difference = NAN;  ///< in light: share inside the target's radius, less the fraction
  double tolerance_share = NAN;   ///< in light: what that may be, margin * max(r dE/dr, kFlattestCurve)
  double spread =
      NAN;  ///< of mirrors of the specification: standard deviation of `difference`; NaN: not known
  Verdict verdict = Verdict::kUndecided;
};

/// How well standard errors are known: an error estimated from n samples has n - 1 degrees of freedom, one
/// that is known, given or zero has infinitely many.
struct DegreesOfFreedom {
  double target = std::numeric_limits<double>::infinity();
  double model = std::numeric_limits<double>::infinity();
};

/// Those of the standard error sqrt(a^2 + b^2) of two independent errors a and b with their own: (a^2 +
/// b^2)^2/(a^4/nu_a + b^4/nu_b) (Welch 1947, Satterthwaite 1946), between the smaller one and the sum of
/// both. Infinite where both errors are zero.
double effective_degrees_of_freedom(double a, double nu_a, double b, double nu_b);

/// Quantile of Student's t at `confidence`; for infinitely many degrees of freedom that of the normal
/// distribution.
double student_quantile(double confidence, double degrees_of_freedom);

/// `equivalent` when the interval lies within +-margin, `different` when it lies wholly outside, else
/// `undecided`. Interval: d +- t se with d = model/target - 1, t the quantile of Student's t at `confidence`
/// for the degrees of freedom of both errors together, and (first order, independent errors) se^2 =
/// (model_error/target)^2 + (model target_error/target^2)^2; good while target_error << |target|. The chance
/// to declare `equivalent` at a true difference of exactly the margin is then at most 1 - confidence.
/// Standard errors: absolute, of target and model, >= 0. A difference that is not a number (NaN or infinity
/// in target or model, target 0 with another model) gives `different`; target = model = 0 is no difference.
/// confidence in (0.5, 1).
EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence,
                       const DegreesOfFreedom& freedom = {});

/// The same for a target as the method states it: in light where its curve is known, else as `tost` with the
/// target's own scale. shown: of the model, in the target's unit; judged: of the model, what aim_of(target)
/// asks for, with its standard error.
EquivalenceMetric judge_target(const Target& target, bool held_out, double shown, double judged,
                               double judged_error, double margin, double confidence,
                               double degrees_of_freedom = std::numeric_limits<double>::infinity());

/// The metric with an interval that allows for a model that is off by up to `model_error` (relative, as the
/// margin is) either way.
EquivalenceMetric with_model_error(EquivalenceMetric metric, double model_error);

/// Whether a metric that is open could be decided by samples enough to leave no more than its model error:
/// whether the interval would leave the edge of the margin with the difference somewhere in what sampling
/// leaves open now. False where it is decided. A target's own standard error counts as sampling.
bool more_samples_could_decide(const EquivalenceMetric& metric);

/// The verdict over all metrics: `different` if any is, else `undecided` if any is, else `equivalent`.
/// Nothing to judge is `undecided`.
Verdict overall(const std::vector<EquivalenceMetric>& metrics);

}  // namespace aberfit
