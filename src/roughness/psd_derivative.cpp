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
#include "psd_models.h"
#include "square.h"
#include "structure_quadrature.h"

namespace aberfit {
using namespace internal;

namespace {

template <class Model>
Model& part_at(Model& model, const std::vector<std::size_t>& part) {
  Model* at = &model;
  for (const std::size_t k : part) at = &std::get<SumPsd>(*at).parts.at(k);
  return *at;
}

const char* const kHeights = "scale";
const char* const kTableValue = "psd";
const char* const kLowest = "f_min";
const char* const kHighest = "f_max";

// Whether it is set, and its change is one of S.
bool may_vary(PsdRole role, double value) {
  if (role == PsdRole::kLowest) return value > 0;
  return role == PsdRole::kHighest ? std::isfinite(value) : role != PsdRole::kFrequency;
}

double& number_at(PsdModel& model, const PsdVariable& parameter) {
  for (const PsdMember& member : psd_members(part_at(model, parameter.part)))
    if (member.key == parameter.key && parameter.row < member.values.size())
      return member.values[parameter.row];
  throw std::invalid_argument("\"" + pointer_of(parameter) + "\" is not a number of this PSD");
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
  for (const PsdMember& member : psd_members(copy))
    for (std::size_t row = 0; row < member.values.size(); ++row)
      if (may_vary(member.role, member.values[row])) found->push_back({member.key, part, row});
}

// The part of a table's d ln S/dp that one row has.
LogSlope slope_of_row(const ModelNumbers& table, std::size_t row) {
  LogSlope slope;
  for (const ModelNumber& column : table) {
    if (column.role == PsdRole::kDensity) slope.hat = 1 / column.values[row];
    if (column.role != PsdRole::kFrequency) continue;
    slope.middle = column.values[row];
    slope.left = row > 0 ? column.values[row - 1] : slope.middle;
    slope.right = row + 1 < column.values.size() ? column.values[row + 1] : slope.middle;
  }
  return slope;
}

// d ln S/dp inside the band if its ends stay, with what keeps the rms.
template <class Model>
LogSlope log_slope(Model m, const PsdVariable& parameter, double end_variance) {
  const ModelNumbers numbers = rules(m).numbers(m);
  double rms = 0;
  for (const ModelNumber& number : numbers)
    if (number.role == PsdRole::kRms && !number.values.empty()) rms = number.values[0];
  if (parameter.key == kHeights) return {.constant = 2};
  for (const ModelNumber& number : numbers) {
    if (number.key != parameter.key) continue;
    LogSlope slope = number.slope;
    switch (number.role) {
      case PsdRole::kRms:
        return {.constant = 2 / rms};
      case PsdRole::kAmplitude:
        return {.constant = 1 / number.values[0]};
      case PsdRole::kDensity:
        return slope_of_row(numbers, parameter.row);
      case PsdRole::kLowest:
      case PsdRole::kHighest:
        if (rms > 0) slope.constant = -end_variance / square(rms);
        break;
      case PsdRole::kLength:
      case PsdRole::kExponent:
        if (rms > 0) slope.constant = -rules(m).mean_slope(m, slope);
        break;
      case PsdRole::kFrequency:
        break;
    }
    return slope;
  }
  return {};
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
  pointer += "/" + parameter.key;
  return parameter.key == kTableValue ? fmt::format("{}/{}", pointer, parameter.row) : pointer;
}

PsdVariable psd_variable(const PsdModel& model, const std::string& pointer) {
  for (const PsdVariable& one : psd_variables(model)) {
    if (pointer_of(one) == pointer) return one;
    PsdVariable heights{kHeights, one.part, 0};
    if (pointer_of(heights) == pointer) return heights;
  }
  throw std::invalid_argument("\"" + pointer + "\" is not a number of this PSD");
}

double value_of(const PsdModel& model, const PsdVariable& parameter) {
  if (parameter.key == kHeights) return 1;
  PsdModel copy = model;
  return number_at(copy, parameter);
}

PsdModel with_value(const PsdModel& model, const PsdVariable& parameter, double value) {
  PsdModel changed = model;
  if (parameter.key == kHeights) {
    PsdModel& part = part_at(changed, parameter.part);
    part = scaled(part, value, 1);
  } else {
    number_at(changed, parameter) = value;
  }
  return changed;
}

PsdDerivative::PsdDerivative(const PsdModel& model, const PsdVariable& parameter)
    : part_(part_at(model, parameter.part)) {
  const bool low = parameter.key == kLowest, high = parameter.key == kHighest;
  double end_variance = 0;
  if (low || high) {
    const double f = low ? part_.f_min() : part_.f_max(), variance = 2 * kPi * f * part_(f);
    end_variance = low ? -variance : variance;
    rings_.push_back({f, end_variance});
  }
  const LogSlope slope = std::visit(
      Overloaded{[&](const SumPsd&) { return LogSlope{.constant = parameter.key == kHeights ? 2.0 : 0}; },
                 [&](const auto& m) { return log_slope(m, parameter, end_variance); }},
      part_at(model, parameter.part));
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
