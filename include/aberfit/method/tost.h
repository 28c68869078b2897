#pragma once
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
  double standard_error = 0;    ///< of the relative difference
  double interval[2] = {0, 0};  ///< confidence interval of it at level 2 confidence - 1 (90 % for 0.95)
  double margin = 0;            ///< relative
  Verdict verdict = Verdict::kUndecided;
};

/// `equivalent` when the interval lies within +-margin, `different` when it lies wholly outside, else
/// `undecided`. Interval: d +- z se with d = model/target - 1, z the normal quantile at `confidence`, and
/// (first order, independent errors) se^2 = (model_error/target)^2 + (model target_error/target^2)^2; good
/// while target_error << |target|. The chance to declare `equivalent` at a true difference of exactly the
/// margin is then at most 1 - confidence. Standard errors: absolute, of target and model, >= 0. A difference
/// that is not a number (NaN or infinity in target or model, target 0 with another model) gives `different`;
/// target = model = 0 is no difference. confidence in (0.5, 1).
EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence);

/// The verdict over all metrics: `different` if any is, else `undecided` if any is, else `equivalent`.
/// Nothing to judge is `undecided`.
Verdict overall(const std::vector<EquivalenceMetric>& metrics);

}  // namespace aberfit
