#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace aberfit {

/// Least squares in a few parameters, each known only as far as the data say.
struct ParameterFitProblem {
  /// Whitened residuals [1] at x and, where `jacobian` is not null, their derivatives (residual, parameter).
  /// False where x is not allowed. Called from one thread at a time.
  std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd* residuals, Eigen::MatrixXd* jacobian)>
      residuals;
  Eigen::VectorXd lower, upper;  ///< ends of what each parameter may be; may be infinite
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

/// Minimum next to the start, which has to be allowed; Levenberg-Marquardt of Ceres to 1e-10 of the step.
/// `kFailed` where the residuals have no value at the start.
ParameterFit fit_parameters(const ParameterFitProblem& problem, const Eigen::VectorXd& start,
                            int max_iterations = 100);

/// (J^T J)^-1 of whitened residuals. A direction that the data do not see at all, of a singular value below
/// 1e-12 of the largest with columns in units of their length, has the variance 1e30 of such units.
Eigen::MatrixXd parameter_covariance(const Eigen::MatrixXd& jacobian);

/// Where the profile of the sum of squares over one parameter, all others free, has risen by `rise`.
struct ProfileInterval {
  double lower = 0, upper = 0;  ///< the ends of what is allowed where it does not rise so far
  bool lower_found = false, upper_found = false;
};
/// Profile likelihood interval of x[parameter] (Venzon and Moolgavkar 1988), both ends to 1 % of their
/// distance: where the profile is a parabola to 5 % that is Wald's interval, and is given as such.
/// `evaluations`, if given, is counted up. The fit has to have converged.
ProfileInterval profile_interval(const ParameterFitProblem& problem, const ParameterFit& fit, int parameter,
                                 double rise, int* evaluations = nullptr);

}  // namespace aberfit
