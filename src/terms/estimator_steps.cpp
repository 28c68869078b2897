#include "estimator_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"

namespace aberfit::internal {

Eigen::ArrayXd estimator_window(WindowKind window, int n) {
  using std::numbers::pi;
  Eigen::ArrayXd w(n);
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) / n, c = std::cos(2 * pi * t), edge = std::min(t, 1 - t) / 0.25;
    switch (window) {
      case WindowKind::kNone:
        w[i] = 1;
        break;
      case WindowKind::kHann:
        w[i] = 0.5 - 0.5 * c;
        break;
      case WindowKind::kHamming:
        w[i] = 0.54 - 0.46 * c;
        break;
      case WindowKind::kBlackmanHarris:
        w[i] = 0.35875 - 0.48829 * c + 0.14128 * std::cos(4 * pi * t) - 0.01168 * std::cos(6 * pi * t);
        break;
      case WindowKind::kWelch:
        w[i] = 1 - (2 * t - 1) * (2 * t - 1);
        break;
      case WindowKind::kTukey:
        w[i] = edge >= 1 ? 1 : 0.5 - 0.5 * std::cos(pi * edge);
        break;
    }
  }
  return w;
}

int detrend_degree(const DetrendOptions& options) {
  if (options.shape == DetrendShape::kNone) return -1;
  if (options.shape == DetrendShape::kEllipse) return 2;
  if (options.degree < 0) throw std::invalid_argument("the degree of detrending must be 0 or more");
  return options.degree;
}

Eigen::MatrixXd orthonormal_polynomials(int n, int degree) {
  if (degree < 0) return Eigen::MatrixXd(n, 0);
  if (degree >= n)
    throw std::invalid_argument("detrending of so high a degree leaves nothing of so small a grid");
  const Eigen::ArrayXd t = (2 * Eigen::ArrayXd::LinSpaced(n, 0, n - 1) - (n - 1)) / std::max(1, n - 1);
  // Columns of Q span what the first columns of the polynomials span, degree by degree.
  return orthonormal_columns(legendre_polynomials(t, degree + 1).matrix());
}

EstimatorBins estimator_bins(int n, double pitch, int bins_per_decade) {
  const double step = 1 / (n * pitch), nyquist = 0.5 * n * step, ratio = std::pow(10, 1.0 / bins_per_decade);
  const double first = step / std::sqrt(ratio);
  const int steps = int(std::log(nyquist * (1 - 1e-9) / first) / std::log(ratio)) + 1;
  EstimatorBins bins;
  bins.of.assign(std::size_t(n) * std::size_t(n), -1);
  std::vector<int> count(std::size_t(steps), 0), place(std::size_t(steps), -1);
  for (int i = 0; i < n * n; ++i) {
    const auto frequency = [n, step](int k) { return (2 * k < n ? k : k - n) * step; };
    const double f = std::hypot(frequency(i % n), frequency(i / n));
    if (f <= 0 || f >= nyquist * (1 - 1e-9)) continue;
    const int bin = std::clamp(int(std::floor(std::log(f / first) / std::log(ratio))), 0, steps - 1);
    bins.of[std::size_t(i)] = bin;
    ++count[std::size_t(bin)];
  }
  std::vector<double> low, high, members;
  for (int b = 0; b < steps; ++b) {
    if (count[std::size_t(b)] == 0) continue;
    place[std::size_t(b)] = int(low.size());
    low.push_back(first * std::pow(ratio, b));
    high.push_back(std::min(first * std::pow(ratio, b + 1), nyquist));
    members.push_back(count[std::size_t(b)]);
  }
  for (std::size_t b = 1; b < low.size(); ++b) low[b] = high[b - 1] = std::sqrt(low[b] * high[b - 1]);
  for (int& bin : bins.of)
    if (bin >= 0) bin = place[std::size_t(bin)];
  const auto as_array = [](const std::vector<double>& v) {
    return Eigen::ArrayXd(Eigen::Map<const Eigen::ArrayXd>(v.data(), Eigen::Index(v.size())));
  };
  bins.low = as_array(low), bins.high = as_array(high), bins.members = as_array(members);
  return bins;
}

}  // namespace aberfit::internal
