#include "log_hankel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/smooth_number.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// Frequencies up to which J0 is complete, over the highest frequency of the points. Above it J0 fades, so
// that nothing rings. They are reached ln(kWhole pi/turn) beyond the last point.
constexpr double kWhole = 0.8;

// arg Gamma(1/2 + iy), y >= 0, by Stirling's series from |z| = 8 on, to 1e-12.
double phase_of_gamma(double y) {
  std::complex<double> z(0.5, y);
  double turned = 0;
  while (std::abs(z) < 8) turned += std::arg(z), z += 1.0;
  const std::complex<double> inverse = 1.0 / z, square = inverse * inverse;
  const std::complex<double> rest =
      inverse * (1 / 12.0 - square * (1 / 360.0 - square * (1 / 1260.0 - square / 1680.0)));
  return ((z - 0.5) * std::log(z) - z + rest).imag() - turned;
}

}  // namespace

LogHankel::LogHankel(double low, double high, double low_y, double high_y, double turn)
    : high_(high), high_y_(high_y), step_(turn / (2 * pi * high * high_y)) {
  const auto steps = Eigen::Index(std::ceil(std::log(high / low) / step_ - 1e-6));
  step_ = std::log(high / low) / double(steps);
  count_x_ = 1 + steps;
  count_y_ = 1 + Eigen::Index(std::ceil(std::log(high_y / low_y) / step_));
  const double room = std::log(pi / turn) + 0.5;
  const auto n = Eigen::Index(smooth_from(count_x_ + count_y_ + Eigen::Index(std::ceil(room / step_))));
  transform_ = std::make_unique<FourierTransform>(1, int(n));
  // x y J0(2 pi x y) has the Mellin transform exp(-2i arg Gamma((1 - i w)/2)) pi^(i w)/(2 pi).
  kernel_ = Eigen::ArrayXcd::Zero(n);
  const double first = std::log(high) + std::log(high_y) - double(count_x_ + count_y_ - 2) * step_;
  for (Eigen::Index k = 0; k <= n / 2; ++k) {
    const double part = 2 * double(k) / double(n), w = pi * part / step_;
    const double size = part < kWhole ? 1 : std::pow(std::cos(0.5 * pi * (part - kWhole) / (1 - kWhole)), 2);
    const std::complex<double> one =
        std::polar(size / double(n), w * (std::log(pi) + first) - 2 * phase_of_gamma(0.5 * w));
    kernel_[k == 0 ? 0 : n - k] = one;
    if (k > 0) kernel_[k] = std::conj(one);
  }
}

Eigen::ArrayXd LogHankel::points(double high, Eigen::Index count) const {
  return high * (step_ * Eigen::ArrayXd::LinSpaced(count, -double(count - 1), 0.0)).exp();
}

void LogHankel::operator()(Eigen::ArrayXcd* values) const {
  values->conservativeResize(kernel_.size());
  values->tail(kernel_.size() - count_x_).setZero();
  (*transform_)(values->data());
  *values *= kernel_;
  (*transform_)(values->data());
  values->conservativeResize(count_y_);
}

}  // namespace aberfit::internal
