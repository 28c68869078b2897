#pragma once
#include <Eigen/Core>

#include "psd_shape_fit.h"

namespace aberfit::internal {

/// Model error of a family: log psd = log E + sampling error + d. d has standard deviation `deviation` (tau)
/// in every bin and correlation exp(-|log f_b - log f_c| / length) between bins; length 0: none. Beyond half
/// a decade (1.2) it could not be distinguished from the shape itself.
struct PsdModelError {
  double deviation = 0, length = 0;
};

/// Returns log psd - log E without the bias of the logarithm of chi-squared bins, psi(dof/2) - log(dof/2).
Eigen::ArrayXd log_residuals(const PsdBand& band, const Eigen::ArrayXd& expected);

/// Covariance of the log residuals: trigamma(dof/2) with the correlation of the bins, plus the model error.
Eigen::MatrixXd log_covariance(const PsdBand& band, const PsdModelError& error);

/// Returns the tau for which sum r^2 / (v + tau^2) equals the degrees of freedom, for independent bins (Paule
/// and Mandel 1982; limit of DerSimonian and Laird's estimate). 0 if sampling explains the residuals.
double independent_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals, int parameters);

/// Returns the likelihood of independent normal log residuals, maximised over tau. Bins are taken as
/// independent, because residuals of one sign over many bins indicate a wrong family. With a correlation over
/// half a decade a power law would fit almost anything.
double log_likelihood_with_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals);

/// Returns tau and length from restricted maximum likelihood (Patterson and Thompson 1971), which accounts
/// for the fitted parameters. gradient: d log E / d theta, bins x parameters.
PsdModelError restricted_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals,
                                     const Eigen::MatrixXd& gradient);

}  // namespace aberfit::internal
