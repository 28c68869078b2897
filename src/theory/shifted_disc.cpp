#include "shifted_disc.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"

namespace aberfit::internal {
namespace {

constexpr double kStep = 0.03;   // in asinh(rho/core)
constexpr double kFirst = 1e-3;  // of the core: stands for its centre
constexpr int kNodes = 32;
constexpr double kNarrowest = 1e-5;  // rad

}  // namespace

ShiftedDisc::ShiftedDisc(const MeanSpot& spot, double core, double reach)
    : rule_(gauss_legendre(kNodes, 0, 1)), core_(core) {
  const auto count = Eigen::Index(std::ceil(std::asinh(reach / core) / kStep)) + 2;
  table_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double rho = core * std::sinh(i == 0 ? kFirst : double(i) * kStep);
    table_[i] = spot.encircled_energy(rho) / (rho * rho);
    if (i == count - 1) end_ = rho, light_ = table_[i] * rho * rho;
  }
}

double ShiftedDisc::mean_irradiance(double rho) const {
  if (rho >= end_) return light_ / (rho * rho);
  const double place = std::asinh(rho / core_) / kStep;
  const auto i = std::min(Eigen::Index(place), table_.size() - 2);
  return table_[i] + (place - double(i)) * (table_[i + 1] - table_[i]);
}

double ShiftedDisc::operator()(double radius, double shift) const {
  // Over the angle b from the edge's point nearest to the axis, in steps that grow from the spot's core or
  // the distance to it on: b = narrow sinh(s).
  const double nearest = std::abs(radius - shift);
  const double narrow = std::clamp(
      std::hypot(0.5 * core_, nearest) / std::sqrt(radius * std::max(radius, shift)), kNarrowest, 1.0);
  const double last = std::asinh(kPi / narrow);
  double sum = 0;
  for (int k = 0; k < kNodes; ++k) {
    const double s = last * rule_.nodes[k], b = narrow * std::sinh(s), sine = std::sin(0.5 * b);
    const double rho = std::sqrt(nearest * nearest + 4 * radius * shift * sine * sine);
    sum += rule_.weights[k] * narrow * std::cosh(s) * mean_irradiance(rho) *
           (radius - shift + 2 * shift * sine * sine);
  }
  return std::max(0.0, radius / kPi * last * sum);
}

}  // namespace aberfit::internal
