#include "diffraction_line_spread.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/fourier_transform.h"
#include "diffraction_transform.h"

namespace aberfit::internal {
namespace {

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
