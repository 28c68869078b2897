#include "aberfit/roughness/psd.h"

#include <algorithm>
#include <cassert>

#include "aberfit/core/constants.h"
#include "square.h"

namespace aberfit {
using namespace internal;

namespace {

// int_1^q t^(p-1) dt = (q^p - 1)/p, without cancellation for p near 0 or q near 1; q may be infinite (p < 0).
double power_integral(double p, double log_q) { return p == 0 ? log_q : std::expm1(p * log_q) / p; }

// Shapes S/factor, their height variance over the model's band for factor = 1, and their limits at both ends.

double shape(const UniformPsd&, double) { return 1.0; }
double shape(const KCorrelationPsd& m, double f) {
  return std::exp(-0.5 * m.exponent * std::log1p(square(m.correlation * f)));
}
double shape(const PowerLawPsd& m, double f) { return std::pow(f, -m.exponent); }
double shape(const GaussianPsd& m, double f) { return std::exp(-square(kPi * m.correlation_length * f)); }
double shape(const TablePsd& m, double f) {
  const auto above = std::upper_bound(m.frequency.begin(), m.frequency.end(), f);
  const std::size_t i =
      std::clamp<std::ptrdiff_t>(above - m.frequency.begin(), 1, std::ptrdiff_t(m.frequency.size()) - 1);
  const double slope = std::log(m.psd[i] / m.psd[i - 1]) / std::log(m.frequency[i] / m.frequency[i - 1]);
  return m.psd[i - 1] * std::pow(f / m.frequency[i - 1], slope);
}
double shape(const SumPsd&, double) { return 0.0; }  // sums are flattened, so this is never a part

double factor(const UniformPsd& m) {
  return square(m.rms) / (kPi * (m.f_max - m.f_min) * (m.f_max + m.f_min));
}
double factor(const KCorrelationPsd& m) {
  // With v = 1 + (B f)^2 the height variance is pi/B^2 int v^(-c/2) dv.
  const double v_min = 1 + square(m.correlation * m.f_min);
  const double step = square(m.correlation) * (m.f_max - m.f_min) * (m.f_max + m.f_min);
  const double p = 1 - 0.5 * m.exponent;
  const double integral = std::pow(v_min, p) * power_integral(p, std::log1p(step / v_min));
  return square(m.rms) / (kPi / square(m.correlation) * integral);
}
double factor(const PowerLawPsd& m) {
  if (m.amplitude) return *m.amplitude;
  const double p = 2 - m.exponent;
  const double integral = m.f_min > 0 ? std::pow(m.f_min, p) * power_integral(p, std::log(m.f_max / m.f_min))
                                      : std::pow(m.f_max, p) / p;
  return square(*m.rms) / (2 * kPi * integral);
}
double factor(const GaussianPsd& m) { return kPi * square(m.correlation_length * m.rms); }
double factor(const TablePsd&) { return 1.0; }
double factor(const SumPsd&) { return 0.0; }

PowerTerm low_term(const PowerLawPsd& m) { return {1.0, m.exponent}; }
template <class Model>
PowerTerm low_term(const Model&) {
  return {1.0, 0.0};
}
PowerTerm high_term(const PowerLawPsd& m) { return {1.0, m.exponent}; }
PowerTerm high_term(const KCorrelationPsd& m) { return {1.0, m.exponent, 1 / m.correlation}; }
template <class Model>
PowerTerm high_term(const Model&) {  // a Gaussian falls faster than any power
  return {0.0, 0.0};
}

template <class Model>
double lower_edge(const Model& m) {
  if constexpr (requires { m.f_min; }) return m.f_min;
  if constexpr (requires { m.frequency; }) return m.frequency.front();
  return 0.0;
}
template <class Model>
double upper_edge(const Model& m) {
  if constexpr (requires { m.f_max; }) return m.f_max;
  if constexpr (requires { m.frequency; }) return m.frequency.back();
  return kInfinity;
}

void add_bends(const KCorrelationPsd& m, std::vector<double>* bends) { bends->push_back(1 / m.correlation); }
void add_bends(const GaussianPsd& m, std::vector<double>* bends) {
  bends->push_back(1 / (kPi * m.correlation_length));
}
void add_bends(const TablePsd& m, std::vector<double>* bends) {
  bends->insert(bends->end(), m.frequency.begin(), m.frequency.end());
}
template <class Model>
void add_bends(const Model&, std::vector<double>*) {}

}  // namespace

RadialPsd::RadialPsd(const PsdModel& model) {
  assert(psd_problem(model).empty());
  if (const auto* sum = std::get_if<SumPsd>(&model)) {
    for (const PsdModel& part : sum->parts) {
      const RadialPsd flat(part);
      parts_.insert(parts_.end(), flat.parts_.begin(), flat.parts_.end());
    }
  } else {
    std::visit(
        [&](const auto& m) {
          parts_.push_back({model, factor(m), lower_edge(m), upper_edge(m)});
        },
        model);
  }
  find_band();
}

void RadialPsd::find_band() {
  breakpoints_.clear();
  f_min_ = parts_.empty() ? 0 : kInfinity;
  f_max_ = 0;
  for (const Part& part : parts_) {
    f_min_ = std::min(f_min_, part.f_min);
    f_max_ = std::max(f_max_, part.f_max);
    std::vector<double> bends = {part.f_min, part.f_max};
    std::visit([&](const auto& m) { add_bends(m, &bends); }, part.model);
    for (const double f : bends)
      if (f >= part.f_min && f <= part.f_max && f > 0 && std::isfinite(f)) breakpoints_.push_back(f);
  }
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
}

double RadialPsd::operator()(double f) const {
  double sum = 0;
  for (const Part& part : parts_)
    if (f >= part.f_min && f <= part.f_max)
      sum += part.factor * std::visit([f](const auto& m) { return shape(m, f); }, part.model);
  return sum;
}

RadialPsd RadialPsd::scaled(double height_factor) const {
  RadialPsd result = *this;
  for (Part& part : result.parts_) part.factor *= square(height_factor);
  return result;
}

RadialPsd RadialPsd::band(double f_min, double f_max) const {
  RadialPsd result;
  for (Part part : parts_) {
    part.f_min = std::max(part.f_min, f_min);
    part.f_max = std::min(part.f_max, f_max);
    if (part.f_min < part.f_max) result.parts_.push_back(part);
  }
  result.find_band();
  return result;
}

std::vector<PowerTerm> RadialPsd::low_frequency_terms() const {
  std::vector<PowerTerm> terms;
  for (const Part& part : parts_)
    if (part.f_min == 0) {
      PowerTerm term = std::visit([](const auto& m) { return low_term(m); }, part.model);
      term.amplitude *= part.factor;
      terms.push_back(term);
    }
  return terms;
}

std::vector<PowerTerm> RadialPsd::high_frequency_terms() const {
  std::vector<PowerTerm> terms;
  for (const Part& part : parts_)
    if (std::isinf(part.f_max)) {
      PowerTerm term = std::visit([](const auto& m) { return high_term(m); }, part.model);
      term.amplitude *= part.factor;
      if (term.amplitude > 0) terms.push_back(term);
    }
  return terms;
}

}  // namespace aberfit
