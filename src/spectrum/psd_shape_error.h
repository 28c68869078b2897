#pragma once
#include <Eigen/Core>

#include "psd_shape_fit.h"

namespace aberfit::internal {

/// How far a family misses the truth: log psd = log E + sampling error + d, where d has the standard
/// deviation `deviation` (tau) in every bin and the correlation exp(-|log f_b - log f_c| / length) between
/// bins; length 0: none. Half a decade (1.2) is the longest length that is tried: beyond, the discrepancy
/// could not be told from the shape itself.
struct PsdModelError {
  double deviation = 0, length = 0;
};

/// log psd - log E without the bias of the logarithm of chi-squared bins, psi(dof/2) - log(dof/2).
Eigen::ArrayXd log_residuals(const PsdBand& band, const Eigen::ArrayXd& expected);

/// Covariance of the log residuals: trigamma(dof/2), correlated as the bins are, plus the model error's.
Eigen::MatrixXd log_covariance(const PsdBand& band, const PsdModelError& error);

/// tau for which sum r^2 / (v + tau^2) equals the degrees of freedom (bins less parameters): bins taken as
/// independent (Paule and Mandel 1982; the limit of DerSimonian and Laird's). 0 where sampling explains all.
double independent_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals, int parameters);

/// Maximum over tau of the likelihood of independent normal log residuals. Bins taken as independent, because
/// misses that keep their sign over many bins are the sign of a wrong family: with correlation half a decade
/// long a power law passes for anything.
double log_likelihood_with_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals);

/// tau and length by restricted maximum likelihood (Patterson and Thompson 1971), which allows for what the
/// parameters have absorbed. gradient: d log E / d theta, bins x parameters.
PsdModelError restricted_model_error(const PsdBand& band, const Eigen::ArrayXd& residuals,
                                     const Eigen::MatrixXd& gradient);

}  // namespace aberfit::internal
