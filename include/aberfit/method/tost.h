#pragma once
#include <limits>
#include <string>
#include <vector>

namespace aberfit {

enum class Verdict { kEquivalent, kDifferent, kUndecided };
std::string to_string(Verdict verdict);

/// One statistic judged by two one-sided tests (TOST, Schuirmann 1987) on the relative difference
/// model/target - 1.
struct EquivalenceMetric {
  std::string name;
  bool held_out = false;
  double target = 0, model = 0;
  double relative_difference = 0;
  double standard_error = 0;  ///< of the relative difference
  double degrees_of_freedom =
      std::numeric_limits<double>::infinity();  ///< that the standard error is known by
  double interval[2] = {0, 0};  ///< confidence interval of it at level 2 confidence - 1 (90 % for 0.95)
  double margin = 0;            ///< relative
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

/// The verdict over all metrics: `different` if any is, else `undecided` if any is, else `equivalent`.
/// Nothing to judge is `undecided`.
Verdict overall(const std::vector<EquivalenceMetric>& metrics);

}  // namespace aberfit
