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
  Eigen::ArrayXd log_bias;              ///< of log psd: psi(dof/2) - log(dof/2)
  Eigen::ArrayXd log_variance;          ///< of log psd: psi'(dof/2)
  Eigen::ArrayXd node;                  ///< [cycles/m], > 0
  Eigen::MatrixXd response;             ///< bins x nodes
  Eigen::MatrixXd relative_covariance;  ///< of psd / E
  Eigen::MatrixXd precision;            ///< its inverse, directions of vanishing variance left out
  double effective_bins = 0;  ///< independent bins that carry as much: n^2 / sum of squared correlations
  double model_error = 0;     ///< tau that weights the bins beside their sampling error; 0: the likelihood of
                              ///< chi-squared bins
};

/// The trusted bins inside [f_min, f_max] (0: no limit): from 1.5 resolutions on, with positive PSD and
/// response.
PsdBand usable_band(const PsdEstimate& estimate, double f_min, double f_max);

/// A shape fitted to a band.
struct PsdShapeFit {
  PsdShape shape;
  bool converged = false;
  std::string message;
  int iterations = 0;  ///< of the descents that led here
  Eigen::VectorXd theta;
  Eigen::ArrayXd expected;     ///< E of the bins used
  Eigen::MatrixXd covariance;  ///< of theta, for bins that correlate; infinite on the diagonal where the data
                               ///< say nothing or the parameter is at its bound
  double log_likelihood = 0;   ///< Whittle, up to a constant of the data
  double overdispersion = 1;   ///< mean eigenvalue of H^-1 J: by how much correlation of the bins inflates
                               ///< likelihood ratios
  double model_error = 0;      ///< tau allowed for; 0: none
  double weight_error = 0;     ///< tau of the weights: independent bins
};

/// Deviance residuals of the parameters of `shape`, one per bin: r = sign(u) sqrt(dof (q - 1 - log q)),
/// q = psd/E, u = log q. Half their sum of squares is minus the Whittle log-likelihood, up to a constant of
/// the data, so least squares finds its very maximum. With a model error tau: log residuals
/// (psd_shape_error.h) over sqrt(log_variance + tau^2), which misses above and below weigh alike. `band` must
/// outlive the result.
std::unique_ptr<ceres::CostFunction> deviance_residuals(const PsdBand& band, const PsdShape& shape);

/// Maximum of the Whittle likelihood -sum dof/2 (log E + psd/E) over several starts, refined by the
/// quasi-likelihood of the joint covariance: G^T C^-1 (psd/E - 1) = 0 with G = d log E / d theta (McCullagh
/// and Nelder 1989, 9.3), which counts a correlated bin once and has the least variance of all linear
/// estimating equations; unbiased like the likelihood's own.
/// starts: where to begin instead of at guesses from the data.
PsdShapeFit fit_shape(const PsdBand& band, PsdFamily family, int max_iterations,
                      const std::vector<Eigen::VectorXd>& starts = {});

/// Least squares of the log residuals over several starts, weighted by 1 / (psi'(dof/2) + tau^2): every
/// decade counts by its bins, however many ordinates they hold. tau by Paule and Mandel for the weights, by
/// restricted likelihood with its correlation for the covariance, which is the sandwich of these weights
/// between correlated bins. log_likelihood: that of independent normal log bins, at its own maximum over tau;
/// compare it only with its like. model_error stays 0 where sampling explains the residuals.
PsdShapeFit fit_shape_with_model_error(const PsdBand& band, PsdFamily family, int max_iterations);

/// Starting from `fit`, the value of parameter `index` towards `direction` (+1, -1) where the maximum of the
/// likelihood (Whittle's, or that with the model error of `fit`) over the others falls `drop` below that of
/// `fit`; infinite (of that sign) when it does not within the bounds.
double profile_bound(const PsdBand& band, const PsdShapeFit& fit, int index, int direction, double drop,
                     int max_iterations);

/// p-value of the residuals: Wilson-Hilferty normal scores of psd / E, decorrelated, as chi-squared.
double goodness_of_fit(const PsdBand& band, const PsdShapeFit& fit);

}  // namespace aberfit::internal
