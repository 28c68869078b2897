#include "log_slope.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd_integrals.h"
#include "square.h"

namespace aberfit::internal {
namespace {

// (exp(z) (z - 1) + 1)/z^2, 1/2 at 0.
double ramp(double z) {
  if (std::abs(z) > 0.5) return (std::exp(z) * (z - 1) + 1) / (z * z);
  double term = 1, sum = 0;  // sum z^k/(k! (k + 2))
  for (int k = 0; k < 20; ++k) {
    sum += term / (k + 2);
    term *= z / (k + 1);
  }
  return sum;
}

// alpha + beta ln f, the limit of q at one end of an open band.
struct Tail {
  double constant, log;
};
Tail at_zero(const LogSlope& q) { return {q.constant, q.log_f}; }
Tail at_infinity(const LogSlope& q) {
  const double log_b = q.log_knee != 0 ? std::log(q.correlation) : 0;
  return {q.constant + q.knee + 2 * q.log_knee * log_b, q.log_f + 2 * q.log_knee};
}

// 2 pi int f^(power + 1) (alpha + beta ln f) over [a, b], times the sum of `terms`.
double tail_moment(const std::vector<PowerTerm>& terms, const Tail& tail, double power, double a, double b) {
  double sum = 0;
  for (const PowerTerm& term : terms) {
    const double p = power + 2 - term.exponent, low = a > 0 ? std::log(a) : -kInfinity, high = std::log(b);
    const double edge = std::isfinite(high) ? high : low;  // values of S near it do not overflow
    const double scale = term.amplitude * std::exp(p * edge + term.exponent * std::log(term.reference));
    const auto part = [&](int m) { return exponential_integral(m, p, low - edge, high - edge); };
    sum += scale * ((tail.constant + tail.log * edge) * part(0) + (tail.log != 0 ? tail.log * part(1) : 0));
  }
  return 2 * kPi * sum;
}

}  // namespace

double LogSlope::operator()(double f) const {
  double sum = constant + square * f * f;
  if (other) sum += other(f);
  if (log_f != 0) sum += log_f * std::log(f);
  if (log_knee != 0 || knee != 0) {
    const double x = internal::square(correlation * f);
    sum += log_knee * std::log1p(x) + knee * (std::isfinite(x) ? x / (1 + x) : 1);
  }
  if (hat != 0 && f >= left && f <= right) {
    const double end = f < middle ? left : right;
    sum += hat * (f == middle ? 1 : std::log(f / end) / std::log(middle / end));
  }
  return sum;
}

bool LogSlope::is_constant() const {
  return log_f == 0 && log_knee == 0 && knee == 0 && square == 0 && hat == 0 && !other;
}

double exponential_integral(int m, double p, double low, double high) {
  if (std::isinf(low)) return m == 0 ? std::exp(p * high) / p : std::exp(p * high) * (high / p - 1 / (p * p));
  if (std::isinf(high)) return m == 0 ? -std::exp(p * low) / p : -std::exp(p * low) * (low / p - 1 / (p * p));
  const double length = high - low, z = p * length;
  const double flat = std::exp(p * low) * (z == 0 ? length : length * std::expm1(z) / z);
  return m == 0 ? flat : low * flat + std::exp(p * low) * length * length * ramp(z);
}

double slope_moment(const RadialPsd& psd, const LogSlope& slope, double power, double a, double b) {
  a = std::max(a, psd.f_min());
  b = std::min(b, psd.f_max());
  if (!(a < b)) return 0;
  const PowerLawLimits limits = power_law_limits(psd);
  double sum = 0;
  if (a < limits.low) {
    const double upper = std::min(b, limits.low);
    sum += tail_moment(psd.low_frequency_terms(), at_zero(slope), power, a, upper);
    a = upper;
  }
  if (b > limits.high) {
    const double lower = std::max(a, limits.high);
    sum += tail_moment(psd.high_frequency_terms(), at_infinity(slope), power, lower, b);
    b = lower;
  }
  if (a < b)
    for (const PsdPanel& panel : resolved_panels(psd, a, b))
      sum += 2 * kPi * (panel.weight * panel.f.pow(power + 1) * panel.psd * panel.f.unaryExpr([&](double f) {
                         return slope(f);
                       })).sum();
  return sum;
}

}  // namespace aberfit::internal
