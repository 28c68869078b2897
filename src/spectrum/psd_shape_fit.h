#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "psd_shape.h"

namespace aberfit::internal {

/// The bins of an estimate that take part in a fit.
struct PsdBand {
  PsdTableKind kind = PsdTableKind::k2dTwoSided;
  double f_min = 0, f_max = 0;          ///< edges of the outermost bins [cycles/m]
  std::vector<Eigen::Index> bins;       ///< their rows in the estimate
  Eigen::ArrayXd frequency;             ///< of the bins [cycles/m]
  Eigen::ArrayXd psd, dof;              ///< [m^3 or m^4]; > 0
  Eigen::ArrayXd log_bias;              ///< bias of log psd: psi(dof/2) - log(dof/2)
  Eigen::ArrayXd log_variance;          ///< variance of log psd: psi'(dof/2)
  Eigen::ArrayXd node;                  ///< [cycles/m], > 0
  Eigen::MatrixXd response;             ///< bins x nodes
  Eigen::MatrixXd relative_covariance;  ///< covariance of psd / E
  Eigen::MatrixXd precision;            ///< its inverse, without directions of vanishing variance
  double effective_bins = 0;  ///< equivalent number of independent bins: n^2 / sum of squared correlations
  double model_error = 0;     ///< tau in the weights of the bins; 0: likelihood of chi-squared bins
};

/// Returns the usable bins in [f_min, f_max] (0: no limit): above 1.5 resolutions, positive PSD and response.
PsdBand usable_band(const PsdEstimate& estimate, double f_min, double f_max);

struct PsdShapeFit {
  PsdShape shape;
  bool converged = false;
  std::string message;
  int iterations = 0;  ///< iterations of the descents that led here
  Eigen::VectorXd theta;
  Eigen::ArrayXd expected;  ///< E of the bins used
  /// Covariance of theta for correlated bins; infinite on the diagonal if undetermined or at a bound.
  Eigen::MatrixXd covariance;
  double log_likelihood = 0;  ///< Whittle, up to a constant of the data
  /// Mean eigenvalue of H^-1 J, the inflation of likelihood ratios by correlation of the bins.
  double overdispersion = 1;
  double model_error = 0;   ///< tau; 0: none
  double weight_error = 0;  ///< tau of the weights, for independent bins
};

/// Deviance residuals of the parameters of `shape`, one per bin: r = sign(u) sqrt(dof (q - 1 - log q)), q =
/// psd/E, u = log q. Half their sum of squares is minus the Whittle log-likelihood, up to a constant of the
/// data, so least squares maximises it exactly.
/// With a model error tau they are log residuals (psd_shape_error.h) over sqrt(log_variance + tau^2), which
/// weigh deviations up and down alike. `band` must outlive the result.
std::unique_ptr<ceres::CostFunction> deviance_residuals(const PsdBand& band, const PsdShape& shape);

/// Maximises the Whittle likelihood -sum dof/2 (log E + psd/E) from several starts. The result is refined by
/// the quasi-likelihood of the joint covariance: G^T C^-1 (psd/E - 1) = 0 with G = d log E / d theta
/// (McCullagh and Nelder 1989, 9.3). This counts a correlated bin once, is unbiased, and has the least
/// variance of all linear estimating equations.
/// starts: starting points; empty: guesses from the data.
PsdShapeFit fit_shape(const PsdBand& band, PsdFamily family, int max_iterations,
                      const std::vector<Eigen::VectorXd>& starts = {});

/// Least squares of the log residuals from several starts, weighted by 1 / (psi'(dof/2) + tau^2), so that
/// every decade counts by its bins rather than by its ordinates. tau of the weights is by Paule and Mandel.
/// The covariance is the sandwich of these weights with tau and correlation from the restricted likelihood.
/// log_likelihood is that of independent normal log bins, maximised over tau; compare it only with its like.
/// model_error stays 0 if sampling explains the residuals.
PsdShapeFit fit_shape_with_model_error(const PsdBand& band, PsdFamily family, int max_iterations);

/// Starting from `fit`, returns the value of parameter `index` in `direction` (+1, -1) at which the
/// likelihood, maximised over the others, is `drop` below that of `fit`. The likelihood is Whittle's, or that
/// with the model error of `fit`. Infinite (of that sign) if this does not happen within the bounds.
double profile_bound(const PsdBand& band, const PsdShapeFit& fit, int index, int direction, double drop,
                     int max_iterations);

/// Returns the p-value of the residuals: decorrelated Wilson-Hilferty scores of psd / E, as chi-squared.
double goodness_of_fit(const PsdBand& band, const PsdShapeFit& fit);

}  // namespace aberfit::internal
