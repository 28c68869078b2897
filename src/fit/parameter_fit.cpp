#include "aberfit/fit/parameter_fit.h"

#include <ceres/ceres.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace aberfit {
namespace {

constexpr double kUnseen = 1e-12;  // singular value over the largest: a direction without data
constexpr double kUnseenVariance = 1e30;
constexpr double kProfileTolerance = 2e-4;  // relative to the sum of squares
constexpr double kParabola = 0.05;          // fraction of the rise at Wald's ends
constexpr double kEnd = 0.01;               // relative to the distance of an end from the fit
constexpr int kMostDoublings = 40;
constexpr int kMostNarrowings = 12;

class FreeResiduals : public ceres::CostFunction {
 public:
  FreeResiduals(const ParameterFitProblem& problem, const Eigen::VectorXd& at, const std::vector<int>& free,
                int rows, int* evaluations)
      : problem_(problem), at_(at), free_(free), evaluations_(evaluations) {
    set_num_residuals(rows);
    mutable_parameter_block_sizes()->push_back(int(free.size()));
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::VectorXd x = at_, found;
    for (std::size_t k = 0; k < free_.size(); ++k) x[free_[k]] = parameters[0][k];
    Eigen::MatrixXd jacobian;
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    ++*evaluations_;
    if (!problem_.residuals(x, &found, wanted ? &jacobian : nullptr) || !found.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, found.size()) = found;
    if (!wanted) return true;
    if (!jacobian.allFinite()) return false;
    for (Eigen::Index row = 0; row < found.size(); ++row)
      for (std::size_t k = 0; k < free_.size(); ++k)
        jacobians[0][std::size_t(row) * free_.size() + k] = jacobian(row, free_[k]);
    return true;
  }

 private:
  const ParameterFitProblem& problem_;
  const Eigen::VectorXd& at_;
  const std::vector<int>& free_;
  int* evaluations_;
};

// The minimum with x[held] as in `start`; held < 0: over all parameters.
ParameterFit minimum(const ParameterFitProblem& problem, const Eigen::VectorXd& start, int held,
                     int max_iterations, double function_tolerance) {
  ParameterFit fit;
  fit.x = start;
  ++fit.evaluations;
  if (!problem.residuals(start, &fit.residuals, nullptr) || !fit.residuals.allFinite()) {
    fit.message = "no value at the start";
    return fit;
  }
  std::vector<int> free;
  for (int k = 0; k < int(start.size()); ++k)
    if (k != held) free.push_back(k);
  fit.status = ParameterFitStatus::kConverged;
  if (!free.empty()) {
    std::vector<double> values;
    for (const int k : free) values.push_back(start[k]);
    ceres::Problem solver;
    solver.AddResidualBlock(
        new FreeResiduals(problem, start, free, int(fit.residuals.size()), &fit.evaluations), nullptr,
        values.data());
    for (std::size_t k = 0; k < free.size(); ++k) {
      if (std::isfinite(problem.lower[free[k]]))
        solver.SetParameterLowerBound(values.data(), int(k), problem.lower[free[k]]);
      if (std::isfinite(problem.upper[free[k]]))
        solver.SetParameterUpperBound(values.data(), int(k), problem.upper[free[k]]);
    }
    ceres::Solver::Options options;
    options.max_num_iterations = max_iterations;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = function_tolerance;
    options.parameter_tolerance = 1e-10;
    options.gradient_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &solver, &summary);
    for (std::size_t k = 0; k < free.size(); ++k) fit.x[free[k]] = values[k];
    if (summary.termination_type == ceres::NO_CONVERGENCE) fit.status = ParameterFitStatus::kNotConverged;
    if (summary.termination_type == ceres::FAILURE) fit.status = ParameterFitStatus::kFailed;
    fit.message = summary.message;
    problem.residuals(fit.x, &fit.residuals, nullptr);
  }
  fit.sum_of_squares = fit.residuals.squaredNorm();
  return fit;
}

// The profile of one parameter away from the fit.
class ParameterProfile {
 public:
  ParameterProfile(const ParameterFitProblem& problem, const ParameterFit& fit, int parameter,
                   int* evaluations)
      : problem_(problem), fit_(fit), parameter_(parameter), evaluations_(evaluations) {
    const Eigen::MatrixXd covariance = parameter_covariance(fit.jacobian);
    along_ = covariance.col(parameter) / covariance(parameter, parameter);
  }

  /// Rise of the sum of squares at x[parameter] = value; infinite where there is no value. The other
  /// parameters start from the last result nearer to the fit, extrapolated by the derivatives at the fit.
  double rise(double value, Eigen::VectorXd* begin) const {
    Eigen::VectorXd start = *begin + (value - (*begin)[parameter_]) * along_;
    start[parameter_] = value;
    start = start.cwiseMax(problem_.lower).cwiseMin(problem_.upper);
    const ParameterFit there = minimum(problem_, start, parameter_, 50, kProfileTolerance);
    *evaluations_ += there.evaluations;
    if (there.status == ParameterFitStatus::kFailed) return std::numeric_limits<double>::infinity();
    *begin = there.x;
    return there.sum_of_squares - fit_.sum_of_squares;
  }

  /// The end of the interval in the direction of `step`, which is Wald's.
  std::pair<double, bool> end(double step, double wanted) const {
    const double at = fit_.x[parameter_],
                 limit = step > 0 ? problem_.upper[parameter_] : problem_.lower[parameter_];
    const double furthest = std::abs(limit - at);
    double inside = 0, outside = std::min(std::abs(step), furthest), rise_inside = 0;
    const double way = step > 0 ? 1 : -1;
    Eigen::VectorXd near = fit_.x;
    double rise_outside = 0;
    for (int k = 0; k < kMostDoublings; ++k) {
      Eigen::VectorXd begin = near;
      rise_outside = rise(at + way * outside, &begin);
      if (std::abs(rise_outside / wanted - 1) < kParabola && k == 0) return {at + way * outside, true};
      if (rise_outside >= wanted) break;
      if (outside >= furthest) return {limit, false};
      near = begin, inside = outside, rise_inside = rise_outside;
      outside = std::min(2 * outside, furthest);
    }
    if (!(rise_outside >= wanted)) return {limit, false};
    // The root of a parabola rises linearly.
    for (int k = 0; k < kMostNarrowings && outside - inside > kEnd * outside; ++k) {
      const double low = std::sqrt(std::max(rise_inside, 0.0)), high = std::sqrt(rise_outside);
      double share = std::isfinite(high) ? (std::sqrt(wanted) - low) / (high - low) : 0.5;
      share = std::clamp(share, 0.05, 0.95);
      const double middle = inside + share * (outside - inside);
      Eigen::VectorXd begin = near;
      const double there = rise(at + way * middle, &begin);
      if (std::abs(there / wanted - 1) < kEnd) return {at + way * middle, true};
      if (there < wanted)
        near = begin, inside = middle, rise_inside = there;
      else
        outside = middle, rise_outside = there;
    }
    return {at + way * 0.5 * (inside + outside), true};
  }

 private:
  const ParameterFitProblem& problem_;
  const ParameterFit& fit_;
  int parameter_;
  int* evaluations_;
  Eigen::VectorXd along_;  // change of the others per step of the parameter
};

}  // namespace

ParameterFit fit_parameters(const ParameterFitProblem& problem, const Eigen::VectorXd& start,
                            int max_iterations) {
  ParameterFit fit = minimum(problem, start, -1, max_iterations, 1e-10);
  if (fit.status == ParameterFitStatus::kFailed) return fit;
  ++fit.evaluations;
  if (!problem.residuals(fit.x, &fit.residuals, &fit.jacobian) || !fit.jacobian.allFinite())
    fit.status = ParameterFitStatus::kFailed, fit.message = "no derivatives at the minimum";
  return fit;
}

Eigen::MatrixXd parameter_covariance(const Eigen::MatrixXd& jacobian) {
  const Eigen::Index n = jacobian.cols();
  Eigen::VectorXd length = jacobian.colwise().norm();
  for (Eigen::Index k = 0; k < n; ++k)
    if (length[k] == 0) length[k] = 1;
  const Eigen::MatrixXd scaled = jacobian * length.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled, Eigen::ComputeThinV);
  const Eigen::VectorXd& values = svd.singularValues();
  Eigen::VectorXd inverse(values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k)
    inverse[k] = values[k] > kUnseen * values[0] ? std::pow(values[k], -2) : kUnseenVariance;
  const Eigen::MatrixXd v = length.cwiseInverse().asDiagonal() * svd.matrixV();
  return v * inverse.asDiagonal() * v.transpose();
}

ProfileInterval profile_interval(const ParameterFitProblem& problem, const ParameterFit& fit, int parameter,
                                 double rise, int* evaluations) {
  int own = 0;
  const ParameterProfile profile(problem, fit, parameter, evaluations ? evaluations : &own);
  const double std = std::sqrt(parameter_covariance(fit.jacobian)(parameter, parameter));
  const double step = std::sqrt(rise) * std;
  ProfileInterval interval;
  std::tie(interval.lower, interval.lower_found) = profile.end(-step, rise);
  std::tie(interval.upper, interval.upper_found) = profile.end(step, rise);
  return interval;
}

}  // namespace aberfit
