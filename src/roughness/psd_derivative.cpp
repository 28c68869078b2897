#include "aberfit/roughness/psd_derivative.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/psd_integrals.h"
#include "hankel_panels.h"
#include "log_slope.h"
#include "square.h"
#include "structure_quadrature.h"

namespace aberfit {
using namespace internal;

namespace {

using Kind = PsdVariable::Kind;

template <class Model>
Model& part_at(Model& model, const std::vector<std::size_t>& part) {
  Model* at = &model;
  for (const std::size_t k : part) at = &std::get<SumPsd>(*at).parts.at(k);
  return *at;
}

// The number itself; null if the model has none of this kind or it is not set.
template <class Model>
double* number(Model& m, Kind kind, std::size_t row) {
  if constexpr (std::is_same_v<Model, PowerLawPsd>) {
    if (kind == Kind::kRms) return m.rms ? &*m.rms : nullptr;
    if (kind == Kind::kAmplitude) return m.amplitude ? &*m.amplitude : nullptr;
  } else if constexpr (requires { m.rms; }) {
    if (kind == Kind::kRms) return &m.rms;
  }
  if constexpr (requires { m.correlation; })
    if (kind == Kind::kCorrelation) return &m.correlation;
  if constexpr (requires { m.exponent; })
    if (kind == Kind::kExponent) return &m.exponent;
  if constexpr (requires { m.correlation_length; })
    if (kind == Kind::kCorrelationLength) return &m.correlation_length;
  if constexpr (requires { m.f_min; }) {
    if (kind == Kind::kLowest) return m.f_min > 0 ? &m.f_min : nullptr;
    if (kind == Kind::kHighest) return std::isfinite(m.f_max) ? &m.f_max : nullptr;
  }
  if constexpr (std::is_same_v<Model, TablePsd>)
    if (kind == Kind::kTableValue && row < m.psd.size()) return &m.psd[row];
  return nullptr;
}

double* number(PsdModel& model, const PsdVariable& parameter) {
  return std::visit([&](auto& m) { return number(m, parameter.kind, parameter.row); },
                    part_at(model, parameter.part));
}

const char* key_of(Kind kind) {
  static const char* const kKeys[] = {"rms",   "amplitude", "B",   "exponent", "correlation_length",
                                      "f_min", "f_max",     "psd", "scale"};
  return kKeys[std::size_t(kind)];
}

void collect_parameters(const PsdModel& model, const std::vector<std::size_t>& part,
                        std::vector<PsdVariable>* found) {
  if (const auto* sum = std::get_if<SumPsd>(&model)) {
    for (std::size_t k = 0; k < sum->parts.size(); ++k) {
      std::vector<std::size_t> inner = part;
      inner.push_back(k);
      collect_parameters(sum->parts[k], inner, found);
    }
    return;
  }
  PsdModel copy = model;
  const auto* table = std::get_if<TablePsd>(&model);
  for (int kind = 0; kind < int(Kind::kHeights); ++kind)
    for (std::size_t row = 0; row < (Kind(kind) == Kind::kTableValue && table ? table->psd.size() : 1); ++row)
      if (number(copy, {Kind(kind), {}, row})) found->push_back({Kind(kind), part, row});
}

// d ln S/dp inside the band for a given amplitude; `keep_rms` adds the part that keeps the rms.
LogSlope slope_of_shape(const UniformPsd&, const PsdVariable&) { return {}; }
LogSlope slope_of_shape(const KCorrelationPsd& m, const PsdVariable& p) {
  LogSlope slope;
  slope.correlation = m.correlation;
  if (p.kind == Kind::kCorrelation) slope.knee = -m.exponent / m.correlation;
  if (p.kind == Kind::kExponent) slope.log_knee = -0.5;
  return slope;
}
LogSlope slope_of_shape(const PowerLawPsd& m, const PsdVariable& p) {
  LogSlope slope;
  if (p.kind == Kind::kAmplitude) slope.constant = 1 / *m.amplitude;
  if (p.kind == Kind::kExponent) slope.log_f = -1;
  return slope;
}
LogSlope slope_of_shape(const GaussianPsd& m, const PsdVariable& p) {
  LogSlope slope;
  if (p.kind == Kind::kCorrelationLength) slope.square = -2 * kPi * kPi * m.correlation_length;
  return slope;
}
LogSlope slope_of_shape(const TablePsd& m, const PsdVariable& p) {
  LogSlope slope;
  if (p.kind != Kind::kTableValue) return slope;
  slope.hat = 1 / m.psd[p.row];
  slope.middle = m.frequency[p.row];
  slope.left = p.row > 0 ? m.frequency[p.row - 1] : slope.middle;
  slope.right = p.row + 1 < m.psd.size() ? m.frequency[p.row + 1] : slope.middle;
  return slope;
}
LogSlope slope_of_shape(const SumPsd&, const PsdVariable&) { return {}; }

template <class Model>
double rms_kept(const Model& m) {  // 0: no rms
  if constexpr (std::is_same_v<Model, PowerLawPsd>)
    return m.rms.value_or(0);
  else if constexpr (requires { m.rms; })
    return m.rms;
  return 0;
}

// Mean of d ln S/dp, weighted by the height variance, in closed form. It is subtracted if the rms stays
// constant, because S is then divided by an integral over the band.
double mean_slope(const KCorrelationPsd& m, const LogSlope& slope) {
  // With v = 1 + (B f)^2 = exp(w) the height variance is int v^(p - 1) dv = int exp(p w) dw, p = 1 - c/2.
  const double p = 1 - 0.5 * m.exponent;
  const double low = std::log1p(square(m.correlation * m.f_min)),
               high = std::isfinite(m.f_max) ? std::log1p(square(m.correlation * m.f_max)) : kInfinity;
  const double all = exponential_integral(0, p, low, high);
  double sum = 0;
  if (slope.log_knee != 0) sum += slope.log_knee * exponential_integral(1, p, low, high) / all;
  if (slope.knee != 0) sum += slope.knee * (1 - exponential_integral(0, p - 1, low, high) / all);
  return sum;
}
double mean_slope(const PowerLawPsd& m, const LogSlope& slope) {
  const double p = 2 - m.exponent, low = m.f_min > 0 ? std::log(m.f_min) : -kInfinity,
               high = std::log(m.f_max), edge = std::isfinite(high) ? high : low;
  if (slope.log_f == 0) return 0;
  return slope.log_f * (edge + exponential_integral(1, p, low - edge, high - edge) /
                                   exponential_integral(0, p, low - edge, high - edge));
}
double mean_slope(const GaussianPsd& m, const LogSlope& slope) {
  return slope.square / square(kPi * m.correlation_length);  // <f^2> = 1/(pi l)^2
}
template <class Model>
double mean_slope(const Model&, const LogSlope&) {
  return 0;
}

}  // namespace

struct PsdDerivative::Slope {
  LogSlope log;
};

std::vector<PsdVariable> psd_variables(const PsdModel& model) {
  std::vector<PsdVariable> found;
  collect_parameters(model, {}, &found);
  return found;
}

std::string pointer_of(const PsdVariable& parameter) {
  std::string pointer;
  for (const std::size_t k : parameter.part) pointer += fmt::format("/parts/{}", k);
  pointer += fmt::format("/{}", key_of(parameter.kind));
  if (parameter.kind == Kind::kTableValue) pointer += fmt::format("/{}", parameter.row);
  return pointer;
}

PsdVariable psd_variable(const PsdModel& model, const std::string& pointer) {
  for (const PsdVariable& one : psd_variables(model)) {
    if (pointer_of(one) == pointer) return one;
    PsdVariable heights{Kind::kHeights, one.part, 0};
    if (pointer_of(heights) == pointer) return heights;
  }
  throw std::invalid_argument("\"" + pointer + "\" is not a number of this PSD");
}

double value_of(const PsdModel& model, const PsdVariable& parameter) {
  if (parameter.kind == Kind::kHeights) return 1;
  PsdModel copy = model;
  return *number(copy, parameter);
}

PsdModel with_value(const PsdModel& model, const PsdVariable& parameter, double value) {
  PsdModel changed = model;
  if (parameter.kind != Kind::kHeights) {
    *number(changed, parameter) = value;
    return changed;
  }
  std::visit(Overloaded{[&](PowerLawPsd& m) {
                          if (m.rms) m.rms = *m.rms * value;
                          if (m.amplitude) m.amplitude = *m.amplitude * square(value);
                        },
                        [&](TablePsd& m) {
                          for (double& s : m.psd) s *= square(value);
                        },
                        [](SumPsd&) {}, [&](auto& m) { m.rms *= value; }},
             part_at(changed, parameter.part));
  return changed;
}

PsdDerivative::PsdDerivative(const PsdModel& model, const PsdVariable& parameter)
    : part_(part_at(model, parameter.part)) {
  const PsdModel& part = part_at(model, parameter.part);
  LogSlope slope = std::visit([&](const auto& m) { return slope_of_shape(m, parameter); }, part);
  const double rms = std::visit([](const auto& m) { return rms_kept(m); }, part);
  if (parameter.kind == Kind::kHeights) slope.constant = 2;
  if (parameter.kind == Kind::kRms) slope.constant = 2 / rms;
  const bool low = parameter.kind == Kind::kLowest, high = parameter.kind == Kind::kHighest;
  if (low || high) {
    const double f = low ? part_.f_min() : part_.f_max(), variance = 2 * kPi * f * part_(f);
    rings_.push_back({f, low ? -variance : variance});
    if (rms > 0) slope.constant = -rings_.back().variance / square(rms);
  } else if (rms > 0 && !slope.is_constant()) {
    slope.constant = -std::visit([&](const auto& m) { return mean_slope(m, slope); }, part);
  }
  if (high && part_.f_max() >= RadialPsd(model).f_max()) highest_ = 1;
  if (slope.hat != 0) part_ = part_.band(slope.left, slope.right);
  is_whole_ = parameter.part.empty();
  slope_ = std::make_shared<const Slope>(Slope{slope});
}

PsdDerivative PsdDerivative::band(double f_min, double f_max) const {
  PsdDerivative result = *this;
  result.part_ = part_.band(f_min, f_max);
  std::erase_if(result.rings_,
                [&](const Ring& ring) { return ring.frequency < f_min || ring.frequency > f_max; });
  if (part_.f_max() > f_max) result.highest_ = 0;  // S is cut there, whatever the end of the model
  return result;
}

double PsdDerivative::proportion() const {
  return is_whole_ && rings_.empty() && slope_->log.is_constant() ? slope_->log.constant : 0;
}

double PsdDerivative::density(double f) const {
  const double s = part_(f);
  return s > 0 ? s * slope_->log(f) : 0;
}

double PsdDerivative::moment(double power, double a, double b) const {
  double sum = 0;
  if (slope_->log.is_constant()) {
    if (slope_->log.constant != 0) sum = slope_->log.constant * radial_moment(part_, power, a, b);
  } else if (!std::isfinite(radial_moment(part_, power, a, b))) {
    return kNaN;
  } else {
    sum = slope_moment(part_, slope_->log, power, a, b);
  }
  for (const Ring& ring : rings_)
    if (ring.frequency >= a && ring.frequency <= b) sum += ring.variance * std::pow(ring.frequency, power);
  return std::isfinite(sum) ? sum : kNaN;
}

Eigen::ArrayXd PsdDerivative::structure_function(const Eigen::ArrayXd& r) const {
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const LogSlope& slope = slope_->log;
  if (!has_finite_structure_function(part_)) return Eigen::ArrayXd::Constant(r.size(), kNaN);
  if (slope.is_constant()) {
    if (slope.constant != 0) result = slope.constant * aberfit::structure_function(part_, r);
  } else if (part_.f_min() < part_.f_max()) {
    const double r_min = (r > 0).select(r, r_max).minCoeff();
    StructureQuadrature quadrature(part_, {}, r_min, r_max, &slope);
    for (Eigen::Index i = 0; i < r.size(); ++i)
      if (r[i] > 0) result[i] = quadrature(r[i]);
  }
  for (const Ring& ring : rings_) {
    const double weight = ring.variance;
    for (Eigen::Index i = 0; i < r.size(); ++i)
      result[i] += one_minus_j0_sum(2 * kPi * r[i], &ring.frequency, &weight, 1);
  }
  return result;
}

}  // namespace aberfit
