#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/units.h"
#include "detrend_basis.h"
#include "processing.h"
#include "window.h"

namespace aberfit::internal {
namespace {

constexpr double kEvenToRounding = 1e-6;  // fraction of the pitch
constexpr Eigen::Index kFewestSamples = 16;
// Smallest fraction of a wave's power after the trapezoid rule for which it is restored; it corresponds to
// 0.82 of the Nyquist frequency. A smaller limit would amplify noise and aliasing more than the wave.
constexpr double kLeastTransfer = 0.1;

// Natural cubic spline through (x, y), evaluated at n even points x[0] + i pitch.
Eigen::VectorXcd resampled(const std::vector<double>& x, const Eigen::VectorXcd& y, double pitch, int n) {
  const int m = int(x.size());
  Eigen::VectorXcd bend = Eigen::VectorXcd::Zero(m);  // second derivatives, by the Thomas algorithm
  std::vector<double> upper(std::size_t(m), 0);
  for (int i = 1; i + 1 < m; ++i) {
    const double h0 = x[std::size_t(i)] - x[std::size_t(i - 1)],
                 h1 = x[std::size_t(i + 1)] - x[std::size_t(i)];
    const double diagonal = 2 * (h0 + h1) - h0 * upper[std::size_t(i - 1)];
    upper[std::size_t(i)] = h1 / diagonal;
    bend[i] = (6. * ((y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0) - h0 * bend[i - 1]) / diagonal;
  }
  for (int i = m - 2; i > 0; --i) bend[i] -= upper[std::size_t(i)] * bend[i + 1];
  Eigen::VectorXcd result(n);
  int at = 0;
  for (int i = 0; i < n; ++i) {
    const double t = x.front() + i * pitch;
    while (at + 2 < m && t > x[std::size_t(at + 1)]) ++at;
    const double h = x[std::size_t(at + 1)] - x[std::size_t(at)], b = (t - x[std::size_t(at)]) / h, a = 1 - b;
    result[i] = a * y[at] + b * y[at + 1] +
                (h * h / 6) * ((a * a * a - a) * bend[at] + (b * b * b - b) * bend[at + 1]);
  }
  return result;
}

}  // namespace

int even_samples(const Eigen::ArrayXd& x, double pitch) {
  constexpr double kMost = 1 << 26;
  const Eigen::Index n = x.size();
  const double samples = std::round((x[n - 1] - x[0]) / pitch) + 1;
  if (samples <= kMost) return int(samples);
  Eigen::Index gap = 0;
  (x.tail(n - 1) - x.head(n - 1)).maxCoeff(&gap);
  const auto length = [](double value) { return format_quantity(value, Dimension::kLength); };
  throw std::invalid_argument(
      fmt::format("a profile of pitch {} with a gap of {} would have {:.3g} evenly spaced samples; at most "
                  "{:.3g} are possible",
                  length(pitch), length(x[gap + 1] - x[gap]), samples, kMost));
}

ProfileProcessing::ProfileProcessing(const Profile& geometry, const PsdEstimatorOptions& options)
    : quantity_(geometry.quantity) {
  for (Eigen::Index i = 0; i < geometry.size(); ++i)
    if (std::isfinite(geometry.value[i])) valid_.push_back(i);
  const Eigen::Index n = Eigen::Index(valid_.size());
  if (n < kFewestSamples)
    throw std::invalid_argument("a profile needs at least 16 valid samples for a PSD, has " +
                                std::to_string(n));
  x_ = geometry.x(valid_);
  for (Eigen::Index i = 1; i < n; ++i)
    if (!(x_[i] > x_[i - 1])) throw std::invalid_argument("profile.x must ascend strictly");
  const double pitch = median_pitch(geometry);
  const int samples = even_samples(x_, pitch);
  // A step of two or more pitches contains missing samples, listed as invalid in the file or omitted.
  for (Eigen::Index i = 0; i < n; ++i) {
    knots_.push_back({x_[i], i, 0});
    if (i + 1 == n) break;
    const int missing = int(std::lround((x_[i + 1] - x_[i]) / pitch)) - 1;
    if (x_[i + 1] - x_[i] > 1.5 * pitch)
      for (int k = 1; k <= missing; ++k) {
        const double share = double(k) / (missing + 1);
        knots_.push_back({x_[i] + share * (x_[i + 1] - x_[i]), i, share});
      }
  }
  const double span = x_[n - 1] - x_[0];
  pitch_ = span / (samples - 1);
  even_ = samples == int(knots_.size());
  for (std::size_t i = 0; even_ && i < knots_.size(); ++i)
    even_ = std::abs(knots_[i].x - x_[0] - double(i) * pitch_) <= kEvenToRounding * pitch_;
  grid = {1, samples, 1 / (samples * pitch_), 0};
  const int degree = polynomial_degree(options.detrend, true);
  if (degree >= 0) {
    const Eigen::MatrixXd shapes = legendre_basis(x_, x_[0], x_[n - 1], degree);
    const Eigen::MatrixXd gram = shapes.transpose() * shapes;
    basis_ = Cholesky(gram).solve_lower(Eigen::MatrixXd(shapes.transpose())).transpose();
  }
  prepare(options.window);
  if (quantity_ == ProfileQuantity::kSlope) undo_integration();
}

// The trapezoid rule multiplies a wave by x cot(x), x = pi f pitch: the integral of its samples over its own.
void ProfileProcessing::undo_integration() {
  restored = Eigen::ArrayXd::Ones(grid.cols);
  const double least = std::sqrt(kLeastTransfer);
  for (int i = 1; i < grid.cols; ++i) {
    const double f = grid.frequency(i), x = kPi * f * pitch_, left = x / std::tan(x);
    restored[i] = 1 / std::max(left, least);
    if (left < least) grid.lost_from = std::min(grid.lost_from, f);
  }
}

ComplexGrid ProfileProcessing::bridged(const Eigen::VectorXcd& heights) const {
  Eigen::VectorXcd filled(Eigen::Index(knots_.size()));
  std::vector<double> x(knots_.size());
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    const Knot& knot = knots_[i];
    x[i] = knot.x;
    filled[Eigen::Index(i)] = heights[knot.left];
    if (knot.share > 0) filled[Eigen::Index(i)] += knot.share * (heights[knot.left + 1] - heights[knot.left]);
  }
  ComplexGrid samples(1, grid.cols);
  if (even_)
    samples.row(0) = filled.transpose().array();
  else
    samples.row(0) = resampled(x, filled, pitch_, grid.cols).transpose().array();
  apply_window(&samples);
  return samples;
}

ComplexGrid ProfileProcessing::wave(double u, double) const {
  const double f = u * grid.step_x;
  Eigen::VectorXcd heights(x_.size());
  for (Eigen::Index i = 0; i < x_.size(); ++i) heights[i] = std::polar(1.0, 2 * kPi * f * (x_[i] - x_[0]));
  if (quantity_ == ProfileQuantity::kSlope) {
    // The instrument measures the slope 2 pi i f exp(), and the trapezoid rule integrates it. A linear bridge
    // of the slopes across a hole integrates to one trapezoid.
    const std::complex<double> derivative(0, 2 * kPi * f);
    std::complex<double> sum = 0, before = derivative * heights[0];
    heights[0] = 0;
    for (Eigen::Index i = 1; i < x_.size(); ++i) {
      const std::complex<double> slope = derivative * heights[i];
      sum += 0.5 * (slope + before) * (x_[i] - x_[i - 1]);
      before = slope;
      heights[i] = sum;
    }
  }
  if (basis_.size() > 0) {
    const Eigen::VectorXd real = heights.real(), imaginary = heights.imag();
    const Eigen::VectorXd a = basis_.transpose() * real, b = basis_.transpose() * imaginary;
    heights.real() -= basis_ * a;
    heights.imag() -= basis_ * b;
  }
  return bridged(heights);
}

ComplexGrid ProfileProcessing::windowed(const Profile& heights) const {
  return bridged(heights.value(valid_).matrix().cast<std::complex<double>>());
}

}  // namespace aberfit::internal
