#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

// int t^(p-1) dt next to t = 1: from 1 to `ratio` >= 1 (may be infinity), or from `ratio` < 1 (may be 0) to
// 1.
double edge_power_integral(double p, double ratio) {
  if (ratio == 0) return p > 0 ? 1 / p : kInfinity;
  if (std::isinf(ratio)) return p < 0 ? -1 / p : kInfinity;
  return std::abs(p == 0 ? std::log(ratio) : std::expm1(p * std::log(ratio)) / p);
}

// int f^q S^order df between `edge` and `other`, order 1 or 2, if S is the sum of `terms`. It is written in
// f/edge, so only values of S occur.
double power_terms_integral(const std::vector<PowerTerm>& terms, double q, int order, double edge,
                            double other) {
  double sum = 0;
  for (const PowerTerm& one : terms) {
    if (order == 1) sum += one(edge) * edge_power_integral(q + 1 - one.exponent, other / edge);
    if (order == 2)
      for (const PowerTerm& two : terms)
        sum += one(edge) * two(edge) * edge_power_integral(q + 1 - one.exponent - two.exponent, other / edge);
  }
  return std::pow(edge, q + 1) * sum;
}

// 2 pi int_a^b f^(power+1) S^order df.
double moment(const RadialPsd& psd, double power, int order, double a, double b) {
  a = std::max(a, psd.f_min());
  b = std::min(b, psd.f_max());
  if (!(a < b)) return 0;
  const PowerLawLimits limits = power_law_limits(psd);
  double sum = 0;
  if (a < limits.low) {
    const double upper = std::min(b, limits.low);
    sum += power_terms_integral(psd.low_frequency_terms(), power + 1, order, upper, a);
    a = upper;
  }
  if (b > limits.high) {
    const double lower = std::max(a, limits.high);
    sum += power_terms_integral(psd.high_frequency_terms(), power + 1, order, lower, b);
    b = lower;
  }
  if (a < b)
    for (const PsdPanel& panel : resolved_panels(psd, a, b))
      sum += (panel.weight * panel.f.pow(power + 1) * (order == 2 ? panel.psd.square() : panel.psd)).sum();
  return 2 * kPi * sum;
}

}  // namespace

double PsdMoments::rms_height() const { return std::sqrt(height_variance); }
double PsdMoments::rms_slope_per_axis() const { return std::sqrt(0.5 * slope_variance); }

double radial_moment(const RadialPsd& psd, double power, double a, double b) {
  return moment(psd, power, 1, a, b);
}

PsdMoments psd_moments(const RadialPsd& psd) {
  PsdMoments moments;
  moments.height_variance = moment(psd, 0, 1, 0, kInfinity);
  moments.slope_variance = 4 * kPi * kPi * moment(psd, 2, 1, 0, kInfinity);
  moments.f2_squared = moment(psd, 4, 2, 0, kInfinity);
  return moments;
}

double effective_modes(const PsdMoments& moments, double area) {
  const double f2 = moments.slope_variance / (4 * kPi * kPi);
  return area * f2 * f2 / moments.f2_squared;
}

double correlation_length(const RadialPsd& psd) {
  const double height_variance = radial_moment(psd, 0);
  if (!std::isfinite(height_variance)) return kNaN;
  return radial_moment(psd, -1) / (2 * kPi) / height_variance;
}

}  // namespace aberfit
