#include "aberfit/method/tost.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>

namespace aberfit {

std::string to_string(Verdict verdict) {
  constexpr const char* kWords[] = {"equivalent", "different", "undecided"};  // in the order of the enum
  return kWords[int(verdict)];
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

namespace {

Verdict verdict_of(const EquivalenceMetric& metric) {
  const double low = metric.interval[0], high = metric.interval[1], margin = metric.margin;
  if (!std::isfinite(metric.difference)) return Verdict::kDifferent;
  if (low >= -margin && high <= margin) return Verdict::kEquivalent;
  if (low > margin || high < -margin) return Verdict::kDifferent;
  return Verdict::kUndecided;  // also for a NaN standard error, which proves nothing
}

void decide(double confidence, EquivalenceMetric* metric) {
  assert(confidence > 0.5 && confidence < 1.0);
  const double half = student_quantile(confidence, metric->degrees_of_freedom) * metric->standard_error;
  metric->interval[0] = metric->difference - half;
  metric->interval[1] = metric->difference + half;
  metric->verdict = verdict_of(*metric);
}

// This form keeps digits that model/target - 1 would lose; equal values are no difference even at zero.
double relative(double model, double target) { return model == target ? 0.0 : (model - target) / target; }

}  // namespace

EquivalenceMetric tost(const std::string& name, bool held_out, double target, double target_error,
                       double model, double model_error, double margin, double confidence,
                       const DegreesOfFreedom& freedom) {
  EquivalenceMetric metric;
  metric.name = name;
  metric.held_out = held_out;
  metric.target = target;
  metric.model = model;
  metric.margin = margin;
  metric.difference = metric.relative_difference = relative(model, target);
  if (target != 0.0 || model_error != 0.0 || target_error != 0.0) {
    const double of_model = model_error / target,
                 of_target = model == 0.0 ? 0.0 : model / target * (target_error / target);
    metric.standard_error = std::hypot(of_model, of_target);
    metric.degrees_of_freedom =
        effective_degrees_of_freedom(of_target, freedom.target, of_model, freedom.model);
  }
  decide(confidence, &metric);
  return metric;
}

EquivalenceMetric judge_target(const Target& target, bool held_out, double shown, double judged,
                               double judged_error, double margin, double confidence,
                               double degrees_of_freedom) {
  const Target aim = aim_of(target);
  const std::string name = statistic_name(target.statistic);
  const bool of_radius = std::holds_alternative<EncircledEnergyRadius>(target.statistic);
  const bool of_share = is_share(target.statistic);
  if (!(of_radius && target.curve_slope) && !of_share)
    return tost(name, held_out, target.value, target.standard_error, shown, judged_error, margin, confidence,
                {target.degrees_of_freedom, degrees_of_freedom});
  EquivalenceMetric metric;
  metric.name = name;
  metric.held_out = held_out;
  metric.target = target.value;
  metric.model = shown;
  metric.margin = margin;
  metric.relative_difference = relative(shown, target.value);
  metric.share_difference = judged - aim.value;
  metric.tolerance_share = margin * aim.scale;
  // Too much energy inside a radius means that the spot is small.
  metric.difference = (of_share ? 1 : -1) * metric.share_difference / aim.scale;
  metric.standard_error = std::hypot(judged_error, aim.standard_error) / aim.scale;
  metric.degrees_of_freedom = effective_degrees_of_freedom(aim.standard_error, aim.degrees_of_freedom,
                                                           judged_error, degrees_of_freedom);
  decide(confidence, &metric);
  return metric;
}

EquivalenceMetric with_model_error(EquivalenceMetric metric, double model_error) {
  metric.model_error = model_error;
  metric.interval[0] -= model_error;
  metric.interval[1] += model_error;
  metric.verdict = verdict_of(metric);
  return metric;
}

bool more_samples_could_decide(const EquivalenceMetric& metric) {
  if (metric.verdict != Verdict::kUndecided) return false;
  const double sampling = 0.5 * (metric.interval[1] - metric.interval[0]) - metric.model_error;
  // The smallest and largest distance of the difference from zero within the sampling error.
  const double least = std::max(0.0, std::abs(metric.difference) - sampling),
               most = std::abs(metric.difference) + sampling;
  return std::max(metric.margin - least, most - metric.margin) > metric.model_error;
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
