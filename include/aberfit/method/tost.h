#pragma once
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit {

enum class Verdict { kEquivalent, kDifferent, kUndecided };
std::string to_string(Verdict verdict);

/// One statistic with two one-sided tests (TOST, Schuirmann 1987) on a difference relative to the target. For
/// encircled-energy radii with a known curve E(r) (PHYSICS 7), the difference is the energy fraction inside
/// the target's radius minus the nominal fraction, over max(r dE/dr, kFlattestCurve). Where the curve is
/// steep, this equals the relative difference of the radius.
struct EquivalenceMetric {
  std::string name;
  bool held_out = false;
  double target = 0, model = 0;    ///< shown values, in the statistic's unit
  double relative_difference = 0;  ///< model/target - 1 of the shown values
  double difference = 0;           ///< judged difference, to lie within +-margin
  double standard_error = 0;       ///< of `difference`
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< of the standard error
  double interval[2] = {0, 0};    ///< of `difference` at level 2 confidence - 1 (90 % for 0.95)
  double margin = 0;              ///< relative
  double model_error = 0;         ///< bound of the model's own error; `interval` includes it
  double share_difference = NAN;  ///< energy fraction inside the target's radius minus the nominal fraction
  double tolerance_share = NAN;   ///< margin of `share_difference`: margin * max(r dE/dr, kFlattestCurve)
  double spread =
      NAN;  ///< standard deviation of `difference` over mirrors of the specification; NaN: unknown
  Verdict verdict = Verdict::kUndecided;
};

/// Degrees of freedom of standard errors. An error estimated from n samples has n - 1; one that is known,
/// given or zero has infinitely many.
struct DegreesOfFreedom {
  double target = std::numeric_limits<double>::infinity();
  double model = std::numeric_limits<double>::infinity();
};

/// Degrees of freedom of the standard error sqrt(a^2 + b^2) of two independent errors a and b: (a^2 +
/// b^2)^2/(a^4/nu_a + b^4/nu_b) (Welch 1947, Satterthwaite 1946), between the smaller one and the sum of
/// both. Infinite where both errors are zero.
double effective_degrees_of_freedom(double a, double nu_a, double b, double nu_b);

/// Quantile of Student's t at `confidence`; of the normal distribution for infinite degrees of freedom.
double student_quantile(double confidence, double degrees_of_freedom);

/// `equivalent` when the interval lies within +-margin, `different` when it lies wholly outside, else
/// `undecided`. Interval: d +- t se with d = model/target - 1, and t the quantile of Student's t at
/// `confidence` for the degrees of freedom of both errors. To first order, for independent errors, se^2 =
/// (model_error/target)^2 + (model target_error/target^2)^2; valid while target_error << |target|. The
/// probability of `equivalent` at a true difference of exactly the margin is at most 1 - confidence. Standard
/// errors: absolute, >= 0. A difference that is not finite (NaN or infinity in target or model, target 0 with
/// another model) gives `different`; target = model = 0 is no difference. confidence in (0.5, 1).
EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence,
                       const DegreesOfFreedom& freedom = {});

/// The same for a target of the method: as an energy fraction where its curve is known, else as `tost` with
/// the target's own scale. shown: of the model, in the target's unit; judged: the value of aim_of(target) for
/// the model, with its standard error.
EquivalenceMetric judge_target(const Target& target, bool held_out, double shown, double judged,
                               double judged_error, double margin, double confidence,
                               double degrees_of_freedom = std::numeric_limits<double>::infinity());

/// The metric with an interval widened by `model_error` (relative, as the margin is) on either side.
EquivalenceMetric with_model_error(EquivalenceMetric metric, double model_error);

/// Returns whether more samples could decide an undecided metric. True if the interval, reduced to the model
/// error, could leave the edge of the margin for a difference within the present sampling error. False where
/// the metric is decided. A target's own standard error counts as sampling.
bool more_samples_could_decide(const EquivalenceMetric& metric);

/// The verdict over all metrics: `different` if any is, else `undecided` if any is, else `equivalent`.
/// Without metrics it is `undecided`.
Verdict overall(const std::vector<EquivalenceMetric>& metrics);

}  // namespace aberfit
