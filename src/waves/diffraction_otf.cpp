#include "diffraction_otf.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/waves/lag_table.h"
#include "diffraction_transform.h"

namespace aberfit::internal {
namespace {

Eigen::ArrayXd lags_from_first(Eigen::Index nodes) {
  return Eigen::ArrayXd::LinSpaced(nodes - 1, 1.0, double(nodes - 1)) / LagTable::kNodesPerLag;
}

struct Value {
  double profile, slope, curvature;
};

// Phases come from multiplication, restarted every 64 lags. This takes a quarter of the time of a sine per
// lag, with an error of 1e-15 per step.
template <typename Visit>
void each_phase(double xi, Eigen::Index lags, const Visit& visit) {
  const std::complex<double> turn = std::polar(1.0, -kTwoPi * xi);
  std::complex<double> phase = 1;
  for (Eigen::Index m = 0; m < lags; ++m) {
    if (m % 64 == 0) phase = std::polar(1.0, -kTwoPi * xi * double(m));
    visit(m, phase);
    phase *= turn;
  }
}

Value profile_at(const Eigen::ArrayXcd& c, double xi) {
  Value value{c[0].real(), 0, 0};
  each_phase(xi, c.size(), [&](Eigen::Index m, const std::complex<double>& phase) {
    if (m == 0) return;
    const std::complex<double> term = 2.0 * c[m] * phase;
    const double rate = kTwoPi * double(m);
    value.profile += term.real();
    value.slope += rate * term.imag();
    value.curvature -= rate * rate * term.real();
  });
  return value;
}

void add_gradient(double xi, double scale, Eigen::ArrayXcd* gradient) {
  each_phase(xi, gradient->size(), [&](Eigen::Index m, const std::complex<double>& phase) {
    (*gradient)[m] += (m == 0 ? 1.0 : 2.0) * scale * phase;
  });
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

std::optional<double> otf_line_width(const Eigen::ArrayXcd& c, Eigen::ArrayXcd* gradient) {
  const int steps = fast_transform_size(8 * int(c.size()));
  std::vector<std::complex<double>> scan(std::size_t(steps), 0.0);
  scan[0] = 0.5 * c[0].real();
  for (Eigen::Index m = 1; m < c.size(); ++m) scan[std::size_t(m)] = c[m];
  fourier_transform(1, steps, scan.data());
  const int half = steps / 2;
  const auto profile = [&](int k) { return 2 * scan[std::size_t((k + steps) % steps)].real(); };
  int highest = 0;
  for (int k = -half; k < half; ++k)
    if (profile(k) > profile(highest)) highest = k;
  if (!(profile(highest) > 0) || highest == -half || highest == half - 1) return std::nullopt;
  const double pitch = 1.0 / steps;
  // The peak is a zero of the slope inside the two steps around the highest sample.
  double low = (highest - 1) * pitch, high = (highest + 1) * pitch, peak = highest * pitch;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Value value = profile_at(c, peak);
    (value.slope > 0 ? low : high) = peak;
    double next = value.curvature < 0 ? peak - value.slope / value.curvature : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - peak);
    peak = next;
    if (step <= 1e-15) break;
  }
  const double top = profile_at(c, peak).profile;
  const auto crossing = [&](int outward) -> std::optional<double> {
    int k = outward > 0 ? half - 1 : -half;
    if (profile(k) >= 0.5 * top) return std::nullopt;
    while (k != highest && profile(k) < 0.5 * top) k -= outward;
    double inside = k == highest ? peak : k * pitch, outside = (k + outward) * pitch;
    double x = 0.5 * (inside + outside);
    for (int iteration = 0; iteration < 100; ++iteration) {
      const Value value = profile_at(c, x);
      (value.profile >= 0.5 * top ? inside : outside) = x;
      double next = x - (value.profile - 0.5 * top) / value.slope;
      if (!(next > std::min(inside, outside) && next < std::max(inside, outside)))
        next = 0.5 * (inside + outside);
      const double step = std::abs(next - x);
      x = next;
      if (step <= 1e-15) break;
    }
    return x;
  };
  const auto lower = crossing(-1), upper = crossing(+1);
  if (!lower || !upper) return std::nullopt;
  if (gradient) {  // implicit function theorem, as for the profile N(z) of rays
    const double for_upper = -1 / profile_at(c, *upper).slope, for_lower = 1 / profile_at(c, *lower).slope;
    gradient->setZero(c.size());
    add_gradient(*upper, for_upper, gradient);
    add_gradient(*lower, for_lower, gradient);
    add_gradient(peak, -0.5 * (for_upper + for_lower), gradient);
  }
  return *upper - *lower;
}

}  // namespace aberfit::internal
