#include "aberfit/method/tost.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
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

double effective_degrees_of_freedom(double a, double nu_a, double b, double nu_b) {
  const double largest = std::max(std::abs(a), std::abs(b));
  if (!(largest > 0) || !std::isfinite(largest)) return std::numeric_limits<double>::infinity();
  const double p = std::pow(a / largest, 2), q = std::pow(b / largest, 2);
  return (p + q) * (p + q) / (p * p / nu_a + q * q / nu_b);
}

double student_quantile(double confidence, double degrees_of_freedom) {
  if (std::isinf(degrees_of_freedom)) return boost::math::quantile(boost::math::normal(), confidence);
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), confidence);
}

EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence,
                       const DegreesOfFreedom& freedom) {
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
  if (target != 0.0 || model_error != 0.0 || target_error != 0.0) {
    const double of_model = model_error / target,
                 of_target = model == 0.0 ? 0.0 : model / target * (target_error / target);
    metric.standard_error = std::hypot(of_model, of_target);
    metric.degrees_of_freedom =
        effective_degrees_of_freedom(of_target, freedom.target, of_model, freedom.model);
  }
  const double half = student_quantile(confidence, metric.degrees_of_freedom) * metric.standard_error;
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
