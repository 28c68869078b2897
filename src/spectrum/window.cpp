#include "window.h"

#include <cmath>
#include <complex>

#include "aberfit/core/constants.h"

namespace aberfit {
namespace {

double window_value(WindowKind window, double t) {
  const double c = std::cos(2 * kPi * t);
  switch (window) {
    case WindowKind::kNone:
      return 1;
    case WindowKind::kHann:
      return 0.5 - 0.5 * c;
    case WindowKind::kHamming:
      return 0.54 - 0.46 * c;
    case WindowKind::kBlackmanHarris:  // four terms, -92 dB (Harris 1978, table 1)
      return 0.35875 - 0.48829 * c + 0.14128 * std::cos(4 * kPi * t) - 0.01168 * std::cos(6 * kPi * t);
    case WindowKind::kWelch:
      return 1 - (2 * t - 1) * (2 * t - 1);
    case WindowKind::kTukey: {
      const double edge = std::min(t, 1 - t) / 0.25;
      return edge >= 1 ? 1 : 0.5 - 0.5 * std::cos(kPi * edge);
    }
  }
  return 1;
}

}  // namespace

std::string to_string(WindowKind window) {
  // The order is that of the enum.
  static constexpr const char* kNames[] = {"none", "hann", "hamming", "blackman-harris", "welch", "tukey"};
  return kNames[std::size_t(window)];
}

Eigen::ArrayXd window_values(WindowKind window, Eigen::Index n) {
  Eigen::ArrayXd w(n);
  for (Eigen::Index i = 0; i < n; ++i) w[i] = window_value(window, (double(i) + 0.5) / double(n));
  return w;
}

namespace internal {

int main_lobe(WindowKind window) {
  return window == WindowKind::kNone ? 1 : window == WindowKind::kBlackmanHarris ? 4 : 2;
}

double lobe(const Eigen::ArrayXd& window, double nu) {
  std::complex<double> sum = 0;
  const double step = -2 * kPi * nu / double(window.size());
  for (Eigen::Index i = 0; i < window.size(); ++i) sum += std::polar(window[i], step * (double(i) + 0.5));
  return std::norm(sum) / (double(window.size()) * window.square().sum());
}

Eigen::ArrayXd ordinate_covariance(const Eigen::ArrayXd& window) {
  const Eigen::ArrayXd squared = window.square();
  const double scale = double(window.size()) / squared.sum();
  Eigen::ArrayXd result(9);
  // lobe() of w^2 is |sum|^2/(n sum w^4); the factors undo its normalisation.
  for (int d = 0; d <= 8; ++d) {
    const double value = lobe(squared, d) * squared.square().mean() * scale * scale;
    result[d] = value < 1e-4 ? 0 : value;
  }
  return result;
}

}  // namespace internal
}  // namespace aberfit
