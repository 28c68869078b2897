#include "diffraction_otf.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/waves/lag_table.h"

namespace aberfit::internal {
namespace {

Eigen::ArrayXd lags_from_first(Eigen::Index nodes) {
  return Eigen::ArrayXd::LinSpaced(nodes - 1, 1.0, double(nodes - 1)) / LagTable::kNodesPerLag;
}

}  // namespace

MeanScatter::Encircled MeanLight::encircled(double q) const {
  if (dz) {
    const std::optional<MeanScatter::Encircled> there = scatter->in_plane(q * radius, *dz);
    return {there->energy, there->slope * radius};
  }
  return {scatter->encircled_energy(q * radius), scatter->encircled_energy_slope(q * radius) * radius};
}

RadialOtf::RadialOtf(Eigen::ArrayXd values, const MeanLight& mean)
    : values_(std::move(values)),
      mean_(mean),
      lag_(lags_from_first(values_.size())),
      per_lag_(values_.tail(values_.size() - 1) / lag_) {}

Eigen::ArrayXd RadialOtf::energy_weights(double q, Eigen::Index nodes) {
  const Eigen::ArrayXd lag = lags_from_first(nodes), z = kTwoPi * q * lag;
  Eigen::ArrayXd j0(nodes - 1), j1(nodes - 1), weights(nodes);
  bessel_j0_j1(z.data(), int(nodes - 1), j0.data(), j1.data());
  weights[0] = kPi * q * q;
  weights.tail(nodes - 1) = q * j1 / lag;
  return weights;
}

Eigen::ArrayXd RadialOtf::transfer_weights(double end, double lag, Eigen::Index nodes) {
  constexpr double kSame = 1e-4;  // relative to z; the limit's error is of second order
  Eigen::ArrayXd z(nodes + 1), j0(nodes + 1), j1(nodes + 1), weights(nodes);
  z[0] = 0;
  z.segment(1, nodes - 1) = kTwoPi * end * lags_from_first(nodes);
  z[nodes] = kTwoPi * end * lag;
  bessel_j0_j1(z.data(), int(nodes + 1), j0.data(), j1.data());
  const double own = z[nodes], own_j0 = j0[nodes], own_j1 = j1[nodes];
  for (Eigen::Index j = 0; j < nodes; ++j) {
    const double difference = z[j] - own;
    weights[j] = kTwoPi * end * end *
                 (std::abs(difference) < kSame
                      ? 0.5 * (own_j0 * own_j0 + own_j1 * own_j1)
                      : (z[j] * j1[j] * own_j0 - own * j0[j] * own_j1) / (difference * (z[j] + own)));
  }
  return weights;
}

RadialOtf::Encircled RadialOtf::encircled(double q) const {
  if (!mean_.scatter) return of_values(q);
  const MeanScatter::Encircled mean = mean_.encircled(q);
  Encircled sum{mean.energy, mean.slope};
  const Encircled own = of_values(std::min(q, mean_.end));
  sum.energy += own.energy;
  if (q < mean_.end) sum.density += own.density;
  return sum;
}

RadialOtf::Encircled RadialOtf::of_values(double q) const {
  const BesselSums sums = bessel_sums(kTwoPi * q, lag_.data(), per_lag_.data(), int(lag_.size()));
  return {q * (kPi * q * values_[0] + sums.first), kTwoPi * q * (values_[0] + sums.zeroth)};
}

std::optional<double> RadialOtf::radius(double fraction, double q_max) {
  for (const Found& found : found_)
    if (found.fraction == fraction && found.q_max == q_max) return found.radius;
  const std::optional<double> radius = find_radius(fraction, q_max);
  found_.push_back({fraction, q_max, radius});
  return radius;
}

std::optional<double> RadialOtf::find_radius(double fraction, double q_max) {
  // The energy grows with q, so a scan finds the only crossing. Its steps grow with q.
  double low = 0, f_low = -fraction, high = 2.0 / double(values_.size());
  std::size_t doubled = 0;
  const auto energy_of_next = [&] {
    if (doubled == doubled_.size()) doubled_.push_back(energy(high));
    return doubled_[doubled++];
  };
  double f_high = energy_of_next() - fraction;
  while (f_high < 0) {
    if (high >= q_max) return std::nullopt;
    low = high;
    f_low = f_high;
    high = 2 * high;
    if (high <= q_max) {
      f_high = energy_of_next() - fraction;
    } else {
      high = q_max;
      f_high = energy(high) - fraction;
    }
  }
  // Newton's method from the end nearer in energy, kept inside the bracket.
  double q = low + (high - low) * (-f_low) / (f_high - f_low);
  double last_step = high - low;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Encircled at = encircled(q);
    const double f = at.energy - fraction;
    if (f == 0) return q;
    (f < 0 ? low : high) = q;
    double next = at.density > 0 ? q - f / at.density : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - q);
    // Rounding of the sums makes the last digits oscillate.
    if (step <= 4e-15 * q || (step <= 1e-13 * q && step > 0.25 * last_step)) return next;
    last_step = step;
    q = next;
  }
  return q;
}

}  // namespace aberfit::internal
