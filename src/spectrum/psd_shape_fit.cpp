#include "psd_shape_fit.h"

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/linear_algebra.h"
#include "psd_shape_error.h"

namespace aberfit::internal {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLowestBin = 1.5;  // in resolutions; below, detrending has removed the height
// Directions of the bins' correlation matrix with a smaller fraction of its largest variance are combinations
// that the estimator fixes. They hold rounding errors rather than data.
constexpr double kLeastVariance = 1e-6;
// A floor that adds a smaller fraction to the lowest bin is treated as none.
constexpr double kLeastFloor = 1e-6;

MatrixXd inverse_on_range(const MatrixXd& symmetric) {
  const VectorXd scale = symmetric.diagonal().cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * symmetric * scale.asDiagonal());
  const double least = kLeastVariance * eigen.values.maxCoeff();
  const VectorXd inverse =
      eigen.values.unaryExpr([least](double value) { return value > least ? 1 / value : 0.0; });
  return scale.asDiagonal() * eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() *
         scale.asDiagonal();
}

// E = response S and G = d log E / d theta (bins x parameters). `predict` returns false if E is not positive.
struct Prediction {
  ArrayXd expected;
  MatrixXd gradient;
};
bool predict(const PsdBand& band, const PsdShape& shape, const VectorXd& theta, Prediction* prediction) {
  const PsdShapeValues values = shape_values(shape, theta, band.node);
  prediction->expected = band.response * values.value.matrix();
  if (!(prediction->expected > 0).all() || !prediction->expected.allFinite()) return false;
  prediction->gradient.noalias() = band.response * values.derivative;
  prediction->gradient.array().colwise() /= prediction->expected;
  return prediction->gradient.allFinite();
}

class DevianceResiduals : public ceres::CostFunction {
 public:
  DevianceResiduals(const PsdBand& band, const PsdShape& shape) : band_(band), shape_(shape) {
    set_num_residuals(int(band.psd.size()));
    mutable_parameter_block_sizes()->push_back(parameter_count(shape));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int n = parameter_block_sizes()[0];
    Prediction prediction;
    if (!predict(band_, shape_, Eigen::Map<const VectorXd>(parameters[0], n), &prediction)) return false;
    if (band_.model_error > 0) return evaluate_logs(prediction, residuals, jacobians);
    for (Index b = 0; b < band_.psd.size(); ++b) {
      const double u = std::log(band_.psd[b] / prediction.expected[b]);
      // r = u sqrt(dof h), h = (e^u - 1 - u) / u^2, m = (e^u - 1) / u; series near 0 avoid cancellation.
      const bool near = std::abs(u) < 0.02;
      const double h = near ? 0.5 + u * (1. / 6 + u * (1. / 24 + u * (1. / 120 + u / 720)))
                            : (std::expm1(u) - u) / (u * u);
      const double m = std::abs(u) < 1e-8 ? 1 + 0.5 * u : std::expm1(u) / u;
      residuals[b] = u * std::sqrt(band_.dof[b] * h);
      if (!std::isfinite(residuals[b])) return false;
      if (jacobians && jacobians[0]) {
        const double slope = 0.5 * std::sqrt(band_.dof[b] / h) * m;  // dr/du; du = -d log E
        for (int p = 0; p < n; ++p) jacobians[0][b * n + p] = -slope * prediction.gradient(b, p);
      }
    }
    return true;
  }

 private:
  bool evaluate_logs(const Prediction& prediction, double* residuals, double** jacobians) const {
    const Index bins = band_.psd.size();
    const ArrayXd weight = (band_.log_variance + band_.model_error * band_.model_error).rsqrt();
    Eigen::Map<ArrayXd> r(residuals, bins);
    r = weight * log_residuals(band_, prediction.expected);
    if (jacobians && jacobians[0])
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], bins, prediction.gradient.cols()) =
          -(weight.matrix().asDiagonal() * prediction.gradient);
    return r.allFinite();
  }

  const PsdBand& band_;
  const PsdShape shape_;
};

double log_likelihood(const PsdBand& band, const ArrayXd& expected) {
  return -0.5 * (band.dof * (expected.log() + band.psd / expected)).sum();
}

struct Optimum {
  VectorXd theta;
  double cost = kInfinity;
  bool converged = false;
  int iterations = 0;  // sum over all descents that led here
};

// Runs one descent; parameter `fixed` (if >= 0) is held constant.
Optimum descend(const PsdBand& band, const PsdShape& shape, const PsdShapeBounds& bounds, VectorXd theta,
                int max_iterations, int fixed = -1) {
  theta = theta.cwiseMax(bounds.lower).cwiseMin(bounds.upper);
  ceres::Problem problem;
  problem.AddResidualBlock(deviance_residuals(band, shape).release(), nullptr, theta.data());
  for (int p = 0; p < theta.size(); ++p) {
    problem.SetParameterLowerBound(theta.data(), p, bounds.lower[p]);
    problem.SetParameterUpperBound(theta.data(), p, bounds.upper[p]);
  }
  if (fixed >= 0) {
    if (theta.size() == 1)
      problem.SetParameterBlockConstant(theta.data());
    else
      problem.SetManifold(theta.data(), new ceres::SubsetManifold(int(theta.size()), {fixed}));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = max_iterations;
  // Relative to a cost of about half the number of bins, this is far below what a likelihood ratio can
  // resolve. The refinement below converges further.
  options.function_tolerance = 1e-9;
  options.parameter_tolerance = 1e-9;
  options.gradient_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Optimum optimum{theta, summary.final_cost, summary.termination_type == ceres::CONVERGENCE,
                  std::max(0, int(summary.iterations.size()) - 1)};
  if (!summary.IsSolutionUsable()) optimum.cost = kInfinity;
  return optimum;
}

// Straight line through log level over log f, evaluated at log f = `at`.
struct Line {
  double level = 0, exponent = 0;  // level at log f = at
};
Line line_through(const ArrayXd& log_f, const ArrayXd& log_level, const ArrayXd& weight, double at) {
  const double w = weight.sum(), x = (weight * log_f).sum() / w, y = (weight * log_level).sum() / w;
  const double xx = (weight * (log_f - x).square()).sum();
  const double slope = xx > 0 ? (weight * (log_f - x) * (log_level - y)).sum() / xx : 0;
  return {y + slope * (at - x), -slope};
}

// Returns starts from the levels that the data would have without leakage.
std::vector<VectorXd> starts(const PsdBand& band, const PsdShape& shape) {
  const ArrayXd sum = band.response.rowwise().sum();
  const ArrayXd log_level = (band.psd / sum).log();
  const ArrayXd log_f =
      ((band.response * band.node.matrix()).array() / sum).max(band.f_min).min(band.f_max).log();
  const double low = std::log(band.f_min), high = std::log(band.f_max), pivot = std::log(shape.pivot());
  const Line line = line_through(log_f, log_level, band.dof.min(100), pivot);
  const double profile = shape.kind == PsdTableKind::k1dOneSided ? 1 : 0;
  const double last = log_level.tail(std::max<Index>(1, log_level.size() / 8)).mean();
  // Returns level and exponent of a knee at `at`; the exponent connects the flat part with the last bins.
  const auto knee = [&](double share, double end) {
    const double at = low + share * (high - low);
    const ArrayXd below = (log_f < at).cast<double>();
    const double flat = below.sum() > 0 ? (below * log_level).sum() / below.sum() : log_level[0];
    const double exponent = std::clamp((flat - end) / std::max(high - at, 0.3), 0.3, 8.0);
    const double at_pivot = flat - 0.5 * exponent * std::log1p(std::exp(2 * (pivot - at)));
    return Eigen::Vector3d(at_pivot, -at, std::log(exponent));
  };
  std::vector<VectorXd> found;
  const auto add = [&found](std::initializer_list<double> values) {
    found.push_back(Eigen::Map<const VectorXd>(values.begin(), Index(values.size())));
  };
  switch (shape.family) {
    case PsdFamily::kUniform:
      add({log_level.mean()});
      break;
    case PsdFamily::kPowerLaw:
      add({line.level, line.exponent + profile});
      break;
    case PsdFamily::kPowerLawAndFloor: {
      add({line.level, line.exponent + profile, last - 2});
      const Index half = std::max<Index>(2, log_f.size() / 2);
      const Line upper =
          line_through(log_f.head(half), log_level.head(half), band.dof.head(half).min(100), pivot);
      add({upper.level, upper.exponent + profile, last});
      break;
    }
    case PsdFamily::kKCorrelation:
      for (const double share : {0.1, 0.35, 0.6}) {
        const Eigen::Vector3d k = knee(share, last);
        add({k[0], k[1], k[2]});
      }
      break;
    case PsdFamily::kKCorrelationAndFloor:
      for (const double share : {0.1, 0.4})
        for (const double below : {0.1, 2.0}) {
          const Eigen::Vector3d k = knee(share, last - below);
          add({k[0], k[1], k[2] + 0.3, last - below});
        }
      break;
    case PsdFamily::kTwoKCorrelations:
      for (const double share : {0.1, 0.3})
        for (const double step : {1.0, 3.0}) {
          const Eigen::Vector3d first = knee(share, last - 1), second = knee(0.75, last - 1.5);
          const double flat = last + 0.5;
          add({first[0], first[1], first[2], flat, second[1], std::log(step)});
        }
      break;
    case PsdFamily::kAuto:
      break;
  }
  return found;
}

PsdShapeBounds bounds_of(const PsdBand& band, const PsdShape& shape) {
  return shape_bounds(shape, kLeastFloor * (band.psd / band.response.rowwise().sum().array()).minCoeff());
}

// Solves G^T C^-1 (psd/E - 1) = 0 by Fisher scoring from `theta`, which stays if this does not converge.
void refine(const PsdBand& band, const PsdShape& shape, const std::vector<int>& free, VectorXd* theta) {
  VectorXd at = *theta;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Prediction prediction;
    if (!predict(band, shape, at, &prediction)) return;
    const MatrixXd G = prediction.gradient(Eigen::all, free);
    const MatrixXd weighted = band.precision * G;
    const VectorXd right = weighted.transpose() * (band.psd / prediction.expected - 1).matrix();
    VectorXd step = solve_symmetric(G.transpose() * weighted, right);
    if (!step.allFinite()) return;
    const double longest = step.cwiseAbs().maxCoeff();
    if (longest > 0.5) step *= 0.5 / longest;
    for (std::size_t k = 0; k < free.size(); ++k) at[free[k]] += step[Index(k)];
    if (longest < 1e-9) {
      *theta = at;
      return;
    }
  }
}

// Stores the best of the descents from all starts in `fit`; false if none has a finite likelihood.
bool search(const PsdBand& band, const PsdShapeBounds& bounds, const std::vector<VectorXd>& from,
            int max_iterations, PsdShapeFit* fit) {
  // Short descents distinguish the minima; only the best one is continued.
  constexpr int kScouting = 12;
  Optimum best;
  for (const VectorXd& start : from) {
    const Optimum optimum = descend(band, fit->shape, bounds, start,
                                    from.size() > 1 ? std::min(kScouting, max_iterations) : max_iterations);
    if (optimum.cost < best.cost) best = optimum;
  }
  if (best.cost < kInfinity && !best.converged) {
    const int scouted = from.size() > 1 ? best.iterations : 0;
    best = descend(band, fit->shape, bounds, best.theta, max_iterations);
    best.iterations += scouted;
  }
  if (!(best.cost < kInfinity)) {
    fit->message = "no start has a finite likelihood";
    return false;
  }
  fit->converged = best.converged;
  fit->iterations += best.iterations;
  fit->message = fmt::format("{} after {} iteration{}", best.converged ? "settled" : "not settled",
                             fit->iterations, fit->iterations == 1 ? "" : "s");
  fit->theta = best.theta;
  // The knee of lower frequency comes first.
  if (fit->shape.family == PsdFamily::kTwoKCorrelations && fit->theta[1] < fit->theta[4])
    fit->theta << best.theta.tail(3), best.theta.head(3);
  return true;
}

// Returns the parameters inside their range to which the data are sensitive.
std::vector<int> free_parameters(const PsdShapeBounds& bounds, const VectorXd& theta,
                                 const MatrixXd& gradient, const ArrayXd& weight) {
  std::vector<int> free;
  for (int p = 0; p < theta.size(); ++p) {
    const bool inside = theta[p] > bounds.lower[p] + 1e-6 && theta[p] < bounds.upper[p] - 1e-6;
    const bool felt = (gradient.col(p).array().square() * weight).sum() > 1e-6;
    if (inside && felt) free.push_back(p);
  }
  return free;
}

MatrixXd unknown_covariance(Index n) {
  MatrixXd covariance = MatrixXd::Zero(n, n);
  covariance.diagonal().setConstant(kInfinity);
  return covariance;
}

}  // namespace

std::unique_ptr<ceres::CostFunction> deviance_residuals(const PsdBand& band, const PsdShape& shape) {
  return std::make_unique<DevianceResiduals>(band, shape);
}

PsdBand usable_band(const PsdEstimate& estimate, double f_min, double f_max) {
  PsdBand band;
  band.kind = estimate.kind;
  const ArrayXd sum = estimate.response.rowwise().sum();
  if (!(f_min > 0)) f_min = estimate.trusted_from;
  if (!(f_max > 0)) f_max = estimate.trusted_to;
  for (Index b = 0; b < estimate.psd.size(); ++b) {
    const double f = estimate.frequency[b];
    const bool wanted = f >= f_min && f <= f_max;
    if (wanted && f >= kLowestBin * estimate.resolution && estimate.psd[b] > 0 && estimate.dof[b] > 0 &&
        sum[b] > 0)
      band.bins.push_back(b);
  }
  if (band.bins.empty()) return band;
  band.psd = estimate.psd(band.bins);
  band.frequency = estimate.frequency(band.bins);
  band.dof = estimate.dof(band.bins);
  band.log_bias =
      band.dof.unaryExpr([](double dof) { return boost::math::digamma(0.5 * dof); }) - (0.5 * band.dof).log();
  band.log_variance = band.dof.unaryExpr([](double dof) { return boost::math::trigamma(0.5 * dof); });
  band.f_min = estimate.low[band.bins.front()];
  band.f_max = estimate.high[band.bins.back()];
  std::vector<Index> nodes;
  for (Index n = 0; n < estimate.node_frequency.size(); ++n)
    if (estimate.node_frequency[n] > 0) nodes.push_back(n);
  band.node = estimate.node_frequency(nodes);
  band.response = estimate.response(band.bins, nodes);
  band.relative_covariance = estimate.relative_covariance(band.bins, band.bins);
  band.precision = inverse_on_range(band.relative_covariance);
  const VectorXd scale = band.relative_covariance.diagonal().cwiseSqrt().cwiseInverse();
  band.effective_bins = std::pow(double(band.bins.size()), 2) /
                        (scale.asDiagonal() * band.relative_covariance * scale.asDiagonal()).squaredNorm();
  return band;
}

PsdShapeFit fit_shape(const PsdBand& band, PsdFamily family, int max_iterations,
                      const std::vector<VectorXd>& from) {
  PsdShapeFit fit;
  fit.shape = {family, band.kind, band.f_min, band.f_max};
  const PsdShapeBounds bounds = bounds_of(band, fit.shape);
  if (!search(band, bounds, from.empty() ? starts(band, fit.shape) : from, max_iterations, &fit)) return fit;
  Prediction prediction;
  predict(band, fit.shape, fit.theta, &prediction);
  fit.log_likelihood = log_likelihood(band, prediction.expected);
  const std::vector<int> free = free_parameters(bounds, fit.theta, prediction.gradient, band.dof);
  fit.covariance = unknown_covariance(fit.theta.size());
  if (!free.empty()) {
    refine(band, fit.shape, free, &fit.theta);
    predict(band, fit.shape, fit.theta, &prediction);
    const MatrixXd G = prediction.gradient(Eigen::all, free);
    // Sandwich of the estimating equation with weights W: (G^T W G)^-1 G^T W C W G (...)^-1, W = C^-1.
    const MatrixXd W = band.precision;
    const MatrixXd bread =
        solve_symmetric(G.transpose() * W * G, MatrixXd(MatrixXd::Identity(G.cols(), G.cols())));
    const MatrixXd meat = G.transpose() * W * band.relative_covariance * W * G;
    fit.covariance(free, free) = bread * meat * bread;
    // The same for the likelihood: H = G^T D G, J = G^T D C D G, D = dof / 2.
    const MatrixXd DG = (0.5 * band.dof).matrix().asDiagonal() * G;
    const MatrixXd H = G.transpose() * DG, J = DG.transpose() * band.relative_covariance * DG;
    fit.overdispersion = solve_symmetric(H, J).trace() / double(free.size());
  }
  fit.expected = prediction.expected;
  return fit;
}

PsdShapeFit fit_shape_with_model_error(const PsdBand& band, PsdFamily family, int max_iterations) {
  PsdShapeFit fit;
  fit.shape = {family, band.kind, band.f_min, band.f_max};
  const PsdShapeBounds bounds = bounds_of(band, fit.shape);
  PsdBand weighted = band;
  weighted.model_error = 1;
  std::vector<VectorXd> from = starts(band, fit.shape);
  // Weights and curve hardly influence each other, so a few iterations settle both.
  constexpr int kTurns = 8;
  constexpr double kSettled = 0.01;  // relative change of tau
  Prediction prediction;
  for (int turn = 0; turn < kTurns; ++turn) {
    if (!search(weighted, bounds, from, max_iterations, &fit)) return fit;
    predict(band, fit.shape, fit.theta, &prediction);
    const double before = weighted.model_error;
    const double tau =
        independent_model_error(band, log_residuals(band, prediction.expected), int(fit.theta.size()));
    if (!(tau > 0)) break;
    weighted.model_error = tau;
    from = {fit.theta};
    if (std::abs(tau - before) <= kSettled * before) break;
  }
  fit.expected = prediction.expected;
  fit.weight_error = weighted.model_error;
  const ArrayXd residuals = log_residuals(band, fit.expected);
  const ArrayXd weight = (band.log_variance + fit.weight_error * fit.weight_error).inverse();
  fit.log_likelihood = log_likelihood_with_model_error(band, residuals);
  const std::vector<int> free = free_parameters(bounds, fit.theta, prediction.gradient, weight);
  fit.covariance = unknown_covariance(fit.theta.size());
  if (free.empty()) return fit;
  const MatrixXd G = prediction.gradient(Eigen::all, free);
  const PsdModelError error = restricted_model_error(band, residuals, G);
  fit.model_error = error.deviation;
  const MatrixXd WG = weight.matrix().asDiagonal() * G;
  const MatrixXd H = G.transpose() * WG, J = WG.transpose() * log_covariance(band, error) * WG;
  const MatrixXd bread = solve_symmetric(H, MatrixXd(MatrixXd::Identity(H.rows(), H.cols())));
  fit.covariance(free, free) = bread * J * bread;
  fit.overdispersion = (bread * J).trace() / double(free.size());
  return fit;
}

double profile_bound(const PsdBand& unweighted, const PsdShapeFit& fit, int index, int direction, double drop,
                     int max_iterations) {
  PsdBand band = unweighted;
  band.model_error = fit.weight_error;
  const PsdShapeBounds bounds = bounds_of(band, fit.shape);
  const auto cost_at = [&](double value, VectorXd* theta) {
    (*theta)[index] = value;
    const Optimum optimum = descend(band, fit.shape, bounds, *theta, max_iterations, index);
    *theta = optimum.theta;
    return optimum.cost;
  };
  VectorXd theta = fit.theta;
  const double least = descend(band, fit.shape, bounds, theta, max_iterations).cost;
  const double end = direction > 0 ? bounds.upper[index] : bounds.lower[index];
  double inside = fit.theta[index], outside;
  for (double step = 0.5;; step *= 2) {
    outside = inside + direction * step;
    if (direction * (outside - end) >= 0) outside = end;
    if (cost_at(outside, &theta) - least > drop) break;
    if (outside == end) return direction * kInfinity;
    inside = outside;
  }
  for (int bisection = 0; bisection < 7; ++bisection) {  // to 1 % of the distance
    const double middle = 0.5 * (inside + outside);
    (cost_at(middle, &theta) - least > drop ? outside : inside) = middle;
  }
  return 0.5 * (inside + outside);
}

double goodness_of_fit(const PsdBand& band, const PsdShapeFit& fit) {
  // Cube roots of chi-squared bins are normal to 1e-2 in probability for at least two degrees of freedom
  // (Wilson and Hilferty 1931).
  const ArrayXd spread = 2 / (9 * band.dof);
  const VectorXd score = (((band.psd / fit.expected).pow(1. / 3) - (1 - spread)) / spread.sqrt()).matrix();
  const VectorXd scale = band.relative_covariance.diagonal().cwiseSqrt();
  const double chi_squared = score.dot(scale.asDiagonal() * band.precision * scale.asDiagonal() * score);
  const double freedom = double(band.bins.size()) - double(fit.theta.size());
  if (!(freedom > 0)) return 1;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), chi_squared));
}

}  // namespace aberfit::internal
