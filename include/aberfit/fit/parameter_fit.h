#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace aberfit {

/// Least squares in a few parameters without a prior.
struct ParameterFitProblem {
  /// Whitened residuals [1] at x and, where `jacobian` is not null, their derivatives (residual, parameter).
  /// False where x is not allowed. Called from one thread at a time.
  std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd* residuals, Eigen::MatrixXd* jacobian)>
      residuals;
  Eigen::VectorXd lower, upper;  ///< bounds of each parameter; may be infinite
};

enum class ParameterFitStatus { kConverged, kNotConverged, kFailed };

struct ParameterFit {
  ParameterFitStatus status = ParameterFitStatus::kFailed;
  std::string message;
  Eigen::VectorXd x;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  double sum_of_squares = 0;
  int evaluations = 0;
};

/// Local minimum next to the start, which has to be allowed; Levenberg-Marquardt of Ceres to 1e-10 of the
/// step. `kFailed` where the residuals have no value at the start.
ParameterFit fit_parameters(const ParameterFitProblem& problem, const Eigen::VectorXd& start,
                            int max_iterations = 100);

/// (J^T J)^-1 of whitened residuals. A direction without data, with a singular value below 1e-12 of the
/// largest for columns of unit length, has the variance 1e30 in these units.
Eigen::MatrixXd parameter_covariance(const Eigen::MatrixXd& jacobian);

/// The two points where the profile of the sum of squares over one parameter, with all others free, has risen
/// by `rise`.
struct ProfileInterval {
  double lower = 0, upper = 0;  ///< the bound of the parameter where the profile does not rise so far
  bool lower_found = false, upper_found = false;
};
/// Profile likelihood interval of x[parameter] (Venzon and Moolgavkar 1988), both ends to 1 % of their
/// distance. Where the profile is a parabola to 5 %, it returns Wald's interval. evaluations: optional
/// counter, incremented. The fit must have converged.
ProfileInterval profile_interval(const ParameterFitProblem& problem, const ParameterFit& fit, int parameter,
                                 double rise, int* evaluations = nullptr);

}  // namespace aberfit
