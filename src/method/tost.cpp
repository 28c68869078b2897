#include "aberfit/method/tost.h"

#include <boost/math/distributions/normal.hpp>
#include <cassert>
#include <cmath>

namespace aberfit {

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kEquivalent:
      return "equivalent";
    case Verdict::kDifferent:
      return "different";
    case Verdict::kUndecided:
      break;
  }
  return "undecided";
}

EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence) {
  assert(confidence > 0.5 && confidence < 1.0);
  EquivalenceMetric metric;
  metric.name = name;
  metric.held_out = held_out;
  metric.target = target;
  metric.model = model;
  metric.margin = margin;
  // (model - target) / target keeps digits that model/target - 1 would lose; equal values are no difference
  // even at zero.
  metric.relative_difference = model == target ? 0.0 : (model - target) / target;
  metric.standard_error =
      target == 0.0 && model_error == 0.0 && target_error == 0.0
          ? 0.0
          : std::hypot(model_error / target, model == 0.0 ? 0.0 : model / target * (target_error / target));
  const double half = boost::math::quantile(boost::math::normal(), confidence) * metric.standard_error;
  metric.interval[0] = metric.relative_difference - half;
  metric.interval[1] = metric.relative_difference + half;

  if (!std::isfinite(metric.relative_difference)) {
    metric.verdict = Verdict::kDifferent;
  } else if (metric.interval[0] >= -margin && metric.interval[1] <= margin) {
    metric.verdict = Verdict::kEquivalent;
  } else if (metric.interval[0] > margin || metric.interval[1] < -margin) {
    metric.verdict = Verdict::kDifferent;
  } else {
    metric.verdict =
        Verdict::kUndecided;  // also where a standard error is not a number: it can prove nothing
  }
  return metric;
}

Verdict overall(const std::vector<EquivalenceMetric>& metrics) {
  Verdict verdict = metrics.empty() ? Verdict::kUndecided : Verdict::kEquivalent;
  for (const EquivalenceMetric& metric : metrics) {
    if (metric.verdict == Verdict::kDifferent) return Verdict::kDifferent;
    if (metric.verdict == Verdict::kUndecided) verdict = Verdict::kUndecided;
  }
  return verdict;
}

}  // namespace aberfit
