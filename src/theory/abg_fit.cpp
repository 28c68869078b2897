#include "aberfit/theory/abg_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"

namespace aberfit {
namespace {

constexpr int kSamples = 400;
constexpr double kLightBelow = 1e-3;  // fraction of the scattered energy below the range
constexpr double kInsideBand = 1e-6;  // relative distance of the range from a band edge
constexpr double kCliff = 1.5;        // ratio across a band edge at which a range ends
constexpr double kLargestG = 10, kLargestLogB = 20;

double log_of_sum(double one, double two) {  // log(exp(one) + exp(two))
  const double larger = std::max(one, two);
  return larger + std::log1p(std::exp(std::min(one, two) - larger));
}

// The data: log BSDF at log-spaced sines. log a is the mean of the rest; p = (log b, g) remains.
struct Samples {
  Eigen::ArrayXd log_sine, log_bsdf;
  double least_log_b = 0;

  Eigen::ArrayXd denominator(const Eigen::Vector2d& p) const {  // log(b + s^g)
    return log_sine.unaryExpr([&](double u) { return log_of_sum(p[0], p[1] * u); });
  }
  double log_a(const Eigen::Vector2d& p) const { return (log_bsdf + denominator(p)).mean(); }
  Eigen::ArrayXd residuals(const Eigen::Vector2d& p) const {  // log(function/model)
    const Eigen::ArrayXd r = log_bsdf + denominator(p);
    return r - r.mean();
  }
  double cost(const Eigen::Vector2d& p) const { return residuals(p).square().sum(); }
  Eigen::Matrix<double, Eigen::Dynamic, 2> jacobian(const Eigen::Vector2d& p) const {
    const Eigen::ArrayXd share = (p[0] - denominator(p)).exp();  // b / (b + s^g)
    Eigen::Matrix<double, Eigen::Dynamic, 2> j(log_sine.size(), 2);
    j.col(0) = (share - share.mean()).matrix();
    const Eigen::ArrayXd by_g = (1 - share) * log_sine;
    j.col(1) = (by_g - by_g.mean()).matrix();
    return j;
  }
  Eigen::Vector2d inside(Eigen::Vector2d p) const {
    p[0] = std::clamp(p[0], least_log_b, kLargestLogB);
    p[1] = std::clamp(p[1], 0.0, kLargestG);
    return p;
  }
};

// The best of a grid of knees and exponents: the cost has a second valley, with the knee outside.
Eigen::Vector2d best_of_grid(const Samples& samples) {
  const double first = samples.log_sine[0], last = samples.log_sine[samples.log_sine.size() - 1];
  constexpr int kKnees = 24, kExponents = 24;
  Eigen::Vector2d best = samples.inside({0, 0});
  double least = samples.cost(best);
  for (int i = 0; i < kKnees; ++i)
    for (int j = 1; j <= kExponents; ++j) {
      const double g = 0.25 * j, knee = first - 2 + (last - first + 4) * i / (kKnees - 1);
      const Eigen::Vector2d p = samples.inside({g * knee, g});
      const double cost = samples.cost(p);
      if (cost < least) {
        least = cost;
        best = p;
      }
    }
  return best;
}

// Levenberg-Marquardt inside the bounds. A parameter at its bound that would leave is held.
Eigen::Vector2d refined(const Samples& samples, Eigen::Vector2d p) {
  double damping = 1e-3, cost = samples.cost(p);
  for (int i = 0; i < 300 && damping < 1e12; ++i) {
    const auto j = samples.jacobian(p);
    Eigen::Matrix2d normal = j.transpose() * j;
    Eigen::Vector2d step_down = -j.transpose() * samples.residuals(p).matrix();
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d probe = p;
      probe[k] += step_down[k] > 0 ? 1e-9 : -1e-9;
      if (samples.inside(probe)[k] != probe[k]) {
        step_down[k] = 0;
        normal(0, 1) = normal(1, 0) = 0;
      }
      normal(k, k) *= 1 + damping;
      normal(k, k) += 1e-300;
    }
    const Eigen::Vector2d next = samples.inside(p + normal.fullPivLu().solve(step_down));
    const double there = samples.cost(next);
    if (there < cost) {
      const bool done = (next - p).norm() <= 1e-13 * (1 + p.norm());
      p = next;
      cost = there;
      damping = std::max(1e-12, 0.2 * damping);
      if (done) break;
    } else {
      damping *= 5;
    }
  }
  return p;
}

// Chooses the sines of an automatic range.
void choose_range(const ScatterFunction& scatter, double floor, double* low, double* high) {
  const double start = 0.1 * scatter.lowest_sine();
  double below = std::log(start), above = 0;  // logarithms of sines; kLightBelow lies between
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (below + above);
    (scatter.within(std::asin(std::exp(middle))) < kLightBelow * scatter.tis() ? below : above) = middle;
  }
  // A band edge ends the range if single scattering stands out there. At large g it does not show.
  const auto at = [&](double sine) { return scatter.bsdf(std::asin(std::min(1.0, sine))); };
  const double first = scatter.psd().f_min() * scatter.wavelength(),
               last_of_band = std::min(1.0, scatter.psd().f_max() * scatter.wavelength());
  const bool begins = first > 0 && at(first * (1 + kInsideBand)) > kCliff * at(first * (1 - kInsideBand));
  const bool ends = last_of_band < 1 &&
                    at(last_of_band * (1 - kInsideBand)) > kCliff * at(last_of_band * (1 + kInsideBand));
  const double edge = begins ? first * (1 + kInsideBand) : 0;
  *high = ends ? last_of_band * (1 - kInsideBand) : 1;
  *low = std::max(std::exp(above), edge);
  if (*low >= *high) *low = begins ? edge : 0.01 * *high;
  Eigen::ArrayXd sine(kSamples), value(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    sine[i] = *low * std::pow(*high / *low, double(i) / (kSamples - 1));
    value[i] = at(sine[i]);
  }
  const double least = floor * value.maxCoeff();
  int last = kSamples - 1;
  while (last > 1 && value[last] < least) --last;
  *high = sine[last];
}

}  // namespace

double AbgModel::bsdf(double theta) const { return a / (b + std::pow(std::abs(std::sin(theta)), g)); }

double AbgModel::within(double theta) const {
  const double end = std::abs(std::sin(theta));
  if (!(a > 0) || !(end > 0)) return 0;
  if (g == 0) return kPi * a * end * end / (b + 1);
  if (g == 2) return kPi * a * std::log1p(end * end / b);
  // Over t = s^2 the panels are octaves, on which b + s^g is smooth. They go down to where s^g is negligible
  // beside b, or, for exponents below 2, the rest of the integral of s^(1-g) beside the whole.
  const Quadrature rule = gauss_legendre(20, 0, 1);
  double sum = 0, upper = end;
  for (int i = 0; i < 4000; ++i) {
    const double lower = 0.5 * upper;
    const double before = sum;
    for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
      const double s = lower + (upper - lower) * rule.nodes[j];
      sum += (upper - lower) * rule.weights[j] * s / (b + std::pow(s, g));
    }
    upper = lower;
    if (std::pow(upper, g) < b && sum - before < 1e-13 * sum) break;
  }
  return kTwoPi * a * (sum + 0.5 * upper * upper / b);
}

AbgFit fit_abg(const ScatterFunction& scatter, const AbgOptions& options) {
  AbgFit fit;
  if (!(scatter.tis() > 0)) return fit;
  double low = std::sin(options.theta_min), high = std::sin(options.theta_max);
  if (options.theta_min == 0 && options.theta_max == 0) {
    choose_range(scatter, options.floor, &low, &high);
  } else if (!(options.theta_min > 0 && options.theta_min < options.theta_max &&
               options.theta_max <= 0.5 * kPi)) {
    throw std::invalid_argument("ABg fit: the range of angles needs 0 < theta_min < theta_max <= pi/2");
  }
  Samples samples{Eigen::ArrayXd(kSamples), Eigen::ArrayXd(kSamples), std::log(options.least_b)};
  for (int i = 0; i < kSamples; ++i) {
    samples.log_sine[i] = std::log(low) + std::log(high / low) * i / (kSamples - 1);
    samples.log_bsdf[i] = std::log(scatter.bsdf(std::asin(std::min(1.0, std::exp(samples.log_sine[i])))));
  }
  if (!samples.log_bsdf.isFinite().all())
    throw std::invalid_argument(
        "ABg fit: the scatter function is not positive over the whole range of angles");
  const Eigen::Vector2d p = refined(samples, best_of_grid(samples));
  const Eigen::ArrayXd residuals = samples.residuals(p);
  fit.found = true;
  fit.at_least_b = p[0] <= samples.least_log_b + 1e-9;
  fit.model = {std::exp(samples.log_a(p)), fit.at_least_b ? options.least_b : std::exp(p[0]), p[1]};
  fit.theta_min = std::asin(low);
  fit.theta_max = std::asin(std::min(1.0, high));
  fit.largest_error = std::expm1(residuals.abs().maxCoeff());
  fit.rms_error = std::expm1(std::sqrt(residuals.square().mean()));
  fit.tis = fit.model.within(0.5 * kPi);
  fit.light_in_range = scatter.within(fit.theta_max) - scatter.within(fit.theta_min);
  fit.model_in_range = fit.model.within(fit.theta_max) - fit.model.within(fit.theta_min);
  return fit;
}

}  // namespace aberfit
