#include "psd_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cassert>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"

namespace aberfit::internal {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kKneeReach = 50;  // factor outside the band up to which a knee is sought
// 2-D exponent; polished surfaces have smaller ones, and windows resolve no larger one
constexpr double kLargestExponent = 16;

enum class Part { kKnee, kPower, kUniform, kFloor };

int count_of(Part part) { return part == Part::kKnee ? 3 : part == Part::kPower ? 2 : 1; }

struct PlacedPart {
  Part part;
  int at, count;  // its parameters in theta
};

// The order is that of PsdFamily; kAuto has no shape.
std::vector<PlacedPart> parts_of(PsdFamily family) {
  assert(family != PsdFamily::kAuto);
  static const std::vector<Part> kParts[] = {{},
                                             {Part::kPower},
                                             {Part::kKnee},
                                             {Part::kUniform},
                                             {Part::kPower, Part::kFloor},
                                             {Part::kKnee, Part::kFloor},
                                             {Part::kKnee, Part::kKnee}};
  std::vector<PlacedPart> placed;
  int at = 0;
  for (const Part part : kParts[std::size_t(family)]) {
    placed.push_back({part, at, count_of(part)});
    at += count_of(part);
  }
  return placed;
}

bool is_profile(const PsdShape& shape) { return shape.kind == PsdTableKind::k1dOneSided; }

// The following functions return S and its derivatives by theta; `out` or `d` holds the columns of one part.
using Columns = Eigen::Ref<MatrixXd>;

// (1 + (Bf)^2)^(-c/2), normalised to 1 at the pivot.
ArrayXd knee_values(const PsdShape& shape, const double* theta, const ArrayXd& f, Columns d) {
  const double B = std::exp(theta[1]), c = std::exp(theta[2]);
  const double x0 = std::pow(B * shape.pivot(), 2), log0 = std::log1p(x0), share0 = x0 / (1 + x0);
  const ArrayXd x = (B * f).square();
  const ArrayXd log_ratio = x.log1p() - log0;
  ArrayXd value = (theta[0] - 0.5 * c * log_ratio).exp();
  d.col(0) = value;
  d.col(1) = -c * value * (x / (1 + x) - share0);
  d.col(2) = -0.5 * c * value * log_ratio;
  return value;
}

ArrayXd power_values(const PsdShape& shape, const double* theta, const ArrayXd& f, Columns d) {
  const double exponent = theta[1] - (is_profile(shape) ? 1 : 0);
  const ArrayXd log_ratio = (f / shape.pivot()).log();
  ArrayXd value = (theta[0] - exponent * log_ratio).exp();
  d.col(0) = value;
  d.col(1) = -value * log_ratio;
  return value;
}

// Constant S2 up to f_max; its profile is S1 = 4 P0 sqrt(f_max^2 - f^2).
ArrayXd uniform_values(const PsdShape& shape, const double* theta, const ArrayXd& f, Columns d) {
  ArrayXd value = ArrayXd::Constant(f.size(), std::exp(theta[0]));
  if (is_profile(shape)) {
    const double top = shape.f_max * shape.f_max;
    value *= ((top - f.square()).max(0) / (top - std::pow(shape.pivot(), 2))).sqrt();
  }
  d.col(0) = value;
  return value;
}

ArrayXd floor_values(const double* theta, const ArrayXd& f, Columns d) {
  ArrayXd value = ArrayXd::Constant(f.size(), std::exp(theta[0]));
  d.col(0) = value;
  return value;
}

// log K, K = Gamma((C+1)/2) / (2 sqrt(pi) Gamma(C/2)). S2 = K A B (1 + (Bf)^2)^(-(C+1)/2) has the profile S1
// = A (1 + (Bf)^2)^(-C/2) (k_correlation.h), and S2 = K A f^-(C+1) the profile S1 = A f^-C.
double log_abel(double C) {
  return boost::math::lgamma(0.5 * (C + 1)) - boost::math::lgamma(0.5 * C) - std::log(2 * std::sqrt(kPi));
}
double log_abel_derivative(double C) {
  return 0.5 * (boost::math::digamma(0.5 * (C + 1)) - boost::math::digamma(0.5 * C));
}

// Surface PSD S2 [m^4] of a part at f, with derivatives; not for the floor of a profile.
ArrayXd surface_values(const PsdShape& shape, Part part, const double* theta, const ArrayXd& f, Columns d) {
  PsdShape map = shape;
  map.kind = PsdTableKind::k2dTwoSided;
  switch (part) {
    case Part::kKnee: {
      if (!is_profile(shape)) return knee_values(shape, theta, f, d);
      const double B = std::exp(theta[1]), C = std::exp(theta[2]);
      const double x0 = std::pow(B * shape.pivot(), 2), log0 = std::log1p(x0), share0 = x0 / (1 + x0);
      const ArrayXd x = (B * f).square(), log_x = x.log1p();
      ArrayXd value = (theta[0] + 0.5 * C * log0 + theta[1] + log_abel(C) - 0.5 * (C + 1) * log_x).exp();
      d.col(0) = value;
      d.col(1) = value * (C * share0 + 1 - (C + 1) * x / (1 + x));
      d.col(2) = value * C * (0.5 * log0 + log_abel_derivative(C) - 0.5 * log_x);
      return value;
    }
    case Part::kPower: {
      ArrayXd value = power_values(map, theta, f, d);
      if (!is_profile(shape)) return value;
      // S1 = P (f/f0)^-(b-1)  <->  S2 = K P/f0 (f/f0)^-b
      const double factor = std::exp(log_abel(theta[1] - 1)) / shape.pivot();
      value *= factor;
      d *= factor;
      d.col(1).array() += value * log_abel_derivative(theta[1] - 1);
      return value;
    }
    case Part::kUniform: {
      ArrayXd value = uniform_values(map, theta, f, d);
      if (!is_profile(shape)) return value;
      const double factor = 0.25 / std::sqrt(shape.f_max * shape.f_max - std::pow(shape.pivot(), 2));
      d *= factor;
      return value * factor;
    }
    case Part::kFloor:
      assert(!is_profile(shape));
      return floor_values(theta, f, d);
  }
  return {};
}

// Returns the log of the RMS of one part inside the band.
PsdShapeParameter rms_parameter(const PsdShape& shape, Part part, const VectorXd& theta, int at,
                                const std::string& name) {
  PsdShapeParameter rms{name, "m", true, 0, 0, VectorXd::Zero(theta.size()), -1};
  if (part == Part::kFloor && is_profile(shape)) {  // white noise of the instrument along the line
    rms.coordinate = 0.5 * (theta[at] + std::log(shape.f_max - shape.f_min));
    rms.gradient[at] = 0.5;
    return rms;
  }
  // Panels of up to an octave in log f, where the integrand is smooth, with 12 Gauss-Legendre nodes.
  const double from = std::log(shape.f_min), to = std::log(shape.f_max);
  const int panels = std::max(1, int(std::ceil((to - from) / std::numbers::ln2)));
  const Quadrature rule = gauss_legendre(12, 0, (to - from) / panels);
  const int n = count_of(part);
  double variance = 0;
  VectorXd slope = VectorXd::Zero(n);
  MatrixXd d(rule.nodes.size(), n);
  for (int p = 0; p < panels; ++p) {
    const ArrayXd f = (from + (to - from) * p / panels + rule.nodes).exp();
    const ArrayXd weight = 2 * kPi * f.square() * rule.weights;
    variance += (weight * surface_values(shape, part, theta.data() + at, f, d)).sum();
    slope += d.transpose() * weight.matrix();
  }
  rms.coordinate = 0.5 * std::log(variance);
  rms.gradient.segment(at, n) = 0.5 * slope / variance;
  return rms;
}

PsdShapeParameter internal_parameter(const VectorXd& theta, int at, const std::string& name,
                                     const std::string& unit, bool logarithmic, double offset) {
  PsdShapeParameter parameter{name, unit, logarithmic, offset, theta[at], VectorXd::Zero(theta.size()), at};
  parameter.gradient[at] = 1;
  return parameter;
}

// Returns log S2 of the power law at 1 cycle/m.
PsdShapeParameter amplitude_parameter(const PsdShape& shape, const VectorXd& theta, int at) {
  PsdShapeParameter amplitude{"amplitude", "m^4", true, 0, 0, VectorXd::Zero(theta.size()), -1};
  // S2 is evaluated at the pivot and extrapolated as a power, because 1 cycle/m may be decades away.
  MatrixXd d(1, 2);
  const double s =
      surface_values(shape, Part::kPower, theta.data() + at, ArrayXd::Constant(1, shape.pivot()), d)[0];
  amplitude.coordinate = std::log(s) + theta[at + 1] * std::log(shape.pivot());
  amplitude.gradient.segment(at, 2) = d.row(0).transpose() / s;
  amplitude.gradient[at + 1] += std::log(shape.pivot());
  return amplitude;
}

}  // namespace

double PsdShape::pivot() const { return std::sqrt(f_min * f_max); }

double PsdShapeParameter::natural(double at) const { return offset + (logarithmic ? std::exp(at) : at); }

int parameter_count(const PsdShape& shape) {
  int parameters = 0;
  for (const PlacedPart& part : parts_of(shape.family)) parameters += part.count;
  return parameters;
}

PsdShapeValues shape_values(const PsdShape& shape, const VectorXd& theta, const ArrayXd& f) {
  PsdShapeValues values{ArrayXd::Zero(f.size()), MatrixXd(f.size(), theta.size())};
  for (const auto& [part, at, count] : parts_of(shape.family)) {
    const double* own = theta.data() + at;
    Columns d = values.derivative.middleCols(at, count);
    switch (part) {
      case Part::kKnee:
        values.value += knee_values(shape, own, f, d);
        break;
      case Part::kPower:
        values.value += power_values(shape, own, f, d);
        break;
      case Part::kUniform:
        values.value += uniform_values(shape, own, f, d);
        break;
      case Part::kFloor:
        values.value += floor_values(own, f, d);
        break;
    }
  }
  return values;
}

PsdShapeBounds shape_bounds(const PsdShape& shape, double floor_level) {
  const int n = parameter_count(shape);
  const double profile = is_profile(shape) ? 1 : 0;
  PsdShapeBounds bounds{VectorXd(n), VectorXd(n)};
  for (const auto& [part, at, count] : parts_of(shape.family)) {
    // At the pivot, the level of a steep part may be far below the others.
    const double lowest = std::log(floor_level), reach = 200;
    bounds.lower[at] = part == Part::kFloor ? lowest : lowest - reach;
    bounds.upper[at] = lowest + reach;
    if (part == Part::kKnee) {
      bounds.lower[at + 1] = std::log(1 / (kKneeReach * shape.f_max));
      bounds.upper[at + 1] = std::log(kKneeReach / shape.f_min);
      bounds.lower[at + 2] = std::log(0.1);
      bounds.upper[at + 2] = std::log(kLargestExponent - profile);
    } else if (part == Part::kPower) {
      // For b <= 1 the profile PSD of the surface diverges.
      bounds.lower[at + 1] = profile > 0 ? 1.02 : -4;
      bounds.upper[at + 1] = kLargestExponent;
    }
  }
  return bounds;
}

std::vector<PsdShapeParameter> shape_parameters(const PsdShape& shape, const VectorXd& theta) {
  std::vector<PsdShapeParameter> parameters;
  int knee = 0;
  for (const auto& [part, at, count] : parts_of(shape.family)) {
    const std::string suffix = shape.family == PsdFamily::kTwoKCorrelations ? fmt::format("_{}", ++knee) : "";
    parameters.push_back(
        rms_parameter(shape, part, theta, at, part == Part::kFloor ? "floor" : "rms" + suffix));
    if (part == Part::kKnee) {
      parameters.push_back(internal_parameter(theta, at + 1, "B" + suffix, "m", true, 0));
      parameters.push_back(
          internal_parameter(theta, at + 2, "exponent" + suffix, "1", true, is_profile(shape) ? 1 : 0));
    } else if (part == Part::kPower) {
      parameters.push_back(internal_parameter(theta, at + 1, "exponent", "1", false, 0));
      parameters.push_back(amplitude_parameter(shape, theta, at));
    }
  }
  return parameters;
}

PsdModel surface_model(const PsdShape& shape, const VectorXd& theta) {
  SumPsd sum;
  for (const auto& [part, at, count] : parts_of(shape.family)) {
    if (part == Part::kFloor && is_profile(shape)) continue;
    const double rms = std::exp(rms_parameter(shape, part, theta, at, "rms").coordinate);
    if (part == Part::kKnee) {
      sum.parts.push_back(KCorrelationPsd{rms, std::exp(theta[at + 1]),
                                          std::exp(theta[at + 2]) + (is_profile(shape) ? 1 : 0), shape.f_min,
                                          shape.f_max});
    } else if (part == Part::kPower) {
      sum.parts.push_back(PowerLawPsd{rms, std::nullopt, theta[at + 1], shape.f_min, shape.f_max});
    } else {
      sum.parts.push_back(UniformPsd{rms, shape.f_min, shape.f_max});
    }
  }
  if (sum.parts.size() == 1) return sum.parts.front();
  return sum;
}

}  // namespace aberfit::internal
