#include "psd_shape_error.h"

#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/linear_algebra.h"

namespace aberfit::internal {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Limits of the search for tau: a smaller model error counts as none.
constexpr double kLeast = 1e-3, kMost = 20;
// Correlation lengths in log f, from about the bin spacing (12 per decade) to half a decade.
const double kLengths[] = {0, 0.15, 0.3, 0.6, 1.2};
constexpr int kScan = 10;
constexpr int kBits = 10;  // precision of log tau: 1e-3

MatrixXd correlation(const ArrayXd& frequency, double length) {
  const Index n = frequency.size();
  if (!(length > 0)) return MatrixXd::Identity(n, n);
  const ArrayXd log_f = frequency.log();
  MatrixXd R(n, n);
  for (Index c = 0; c < n; ++c) R.col(c) = (-(log_f - log_f[c]).abs() / length).exp().matrix();
  return R;
}

// Minus twice the restricted log-likelihood of r ~ N(0, covariance) with regressors G, less a constant.
double restricted_deviance(const MatrixXd& covariance, const VectorXd& r, const MatrixXd& G) {
  const Cholesky root(covariance);
  if (!root.positive()) return kInfinity;
  const VectorXd white = root.solve_lower(r);
  const MatrixXd shape = root.solve_lower(G);
  const Cholesky information(shape.transpose() * shape);
  if (!information.positive()) return kInfinity;
  const VectorXd projected = information.solve_lower(VectorXd(shape.transpose() * white));
  return 2 * root.lower().diagonal().array().log().sum() +
         2 * information.lower().diagonal().array().log().sum() + white.squaredNorm() -
         projected.squaredNorm();
}

// Minimum over log tau: flat towards zero with a narrow minimum, so a scan precedes the refinement.
template <class Function>
std::pair<double, double> least_over_log_tau(const Function& at) {
  const double from = std::log(kLeast), step = (std::log(kMost) - from) / kScan;
  double nearest = from, lowest = kInfinity;
  for (int k = 0; k <= kScan; ++k) {
    const double value = at(from + k * step);
    if (value < lowest) lowest = value, nearest = from + k * step;
  }
  return boost::math::tools::brent_find_minima(at, nearest - step, nearest + step, kBits);
}

}  // namespace

ArrayXd log_residuals(const PsdBand& band, const ArrayXd& expected) {
  return (band.psd / expected).log() - band.log_bias;
}

MatrixXd log_covariance(const PsdBand& band, const PsdModelError& error) {
  const VectorXd scale = (band.log_variance / band.relative_covariance.diagonal().array()).sqrt().matrix();
  return scale.asDiagonal() * band.relative_covariance * scale.asDiagonal() +
         error.deviation * error.deviation * correlation(band.frequency, error.length);
}

double independent_model_error(const PsdBand& band, const ArrayXd& residuals, int parameters) {
  const double freedom = double(residuals.size()) - parameters;
  const auto excess = [&](double square) {
    return (residuals.square() / (band.log_variance + square)).sum() - freedom;
  };
  if (!(freedom > 0) || !(excess(kLeast * kLeast) > 0)) return 0;
  double low = std::log(kLeast), high = std::log(kMost);
  for (int bisection = 0; bisection < 40; ++bisection) {
    const double middle = 0.5 * (low + high);
    (excess(std::exp(2 * middle)) > 0 ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

double log_likelihood_with_model_error(const PsdBand& band, const ArrayXd& residuals) {
  const auto minus = [&](double log_tau) {
    const ArrayXd variance = band.log_variance + std::exp(2 * log_tau);
    return 0.5 * (variance.log() + residuals.square() / variance).sum();
  };
  return -least_over_log_tau(minus).second;
}

PsdModelError restricted_model_error(const PsdBand& band, const ArrayXd& residuals,
                                     const MatrixXd& gradient) {
  const MatrixXd sampling = log_covariance(band, {});
  PsdModelError best;
  double least = kInfinity;
  for (const double length : kLengths) {
    const MatrixXd R = correlation(band.frequency, length);
    const auto deviance = [&](double log_tau) {
      return restricted_deviance(sampling + std::exp(2 * log_tau) * R, residuals.matrix(), gradient);
    };
    const auto [log_tau, value] = least_over_log_tau(deviance);
    if (value < least) least = value, best = {std::exp(log_tau), length};
  }
  return best.deviation < 2 * kLeast ? PsdModelError{} : best;
}

}  // namespace aberfit::internal
