#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {

/// Families of PSD models. For profiles, the fitted function is the profile PSD of the isotropic surface.
enum class PsdFamily {
  kAuto,  ///< the information criterion chooses among all others
  kPowerLaw,
  kKCorrelation,
  kUniform,
  kPowerLawAndFloor,  ///< plus a uniform part: instrument noise, or very fine roughness
  kKCorrelationAndFloor,
  kTwoKCorrelations,
};
std::string to_string(PsdFamily family);

struct PsdFitOptions {
  PsdFamily family = PsdFamily::kAuto;
  /// band of the bins to use [cycles/m]; 0: all usable bins (see fit_psd_model)
  double f_min = 0, f_max = 0;
  double confidence = 0.95;
  int max_iterations = 200;
};

/// A model with a smaller goodness does not describe its bins.
inline constexpr double kPoorFit = 1e-3;

/// One parameter of a fitted model.
struct PsdParameter {
  std::string name;  ///< "rms", "B", "exponent", "amplitude", "floor", ...; the exponent is 2-D
  std::string unit;  ///< SI
  double value = 0, std = 0;
  double lower = 0, upper = 0;  ///< confidence interval; may be asymmetric
  bool identified =
      true;  ///< false: the data do not determine it; value is NaN, and at most a bound is known
};

enum class PsdFitStatus { kNotRun, kConverged, kNotConverged, kFailed };
std::string to_string(PsdFitStatus status);

struct PsdCandidate {
  PsdFamily family = PsdFamily::kAuto;
  int parameters = 0;
  double log_likelihood = 0;
  double criterion = 0;  ///< AICc; smaller is better
};

struct PsdModelFit {
  PsdFitStatus status = PsdFitStatus::kNotRun;
  std::string message;
  PsdFamily family = PsdFamily::kAuto;
  /// two-dimensional, two-sided surface PSD in the band of the bins used, ready for a study; without the
  /// floor if that is noise of a profile
  PsdModel model;
  std::vector<PsdParameter> parameters;
  Eigen::MatrixXd covariance;   ///< covariance of the internal (log) parameters, sandwich form
  double f_min = 0, f_max = 0;  ///< band used [cycles/m]
  Eigen::ArrayXd expected;      ///< E[psd] of the model at every bin of the estimate
  Eigen::ArrayXd spectrum;      ///< the model at the frequencies of the bins, of the kind of the estimate
  TablePsd curve;  ///< the same on a dense grid over the band; log-log interpolation keeps integrals to 1e-3
  double log_likelihood = 0, criterion = 0;
  double goodness = 0;  ///< p-value of the residuals, given the model
  /// tau: relative model error allowed in addition to the sampling error; 0: the model describes the bins
  double model_error = 0;
  std::vector<PsdCandidate> candidates;
  Warnings warnings;  ///< `not-identified`, `poor-fit`, ...
};

/// Fits PSD models to the bins by the Whittle (gamma) likelihood of chi-squared bins with E = response * S,
/// which has no log bias (Whittle 1953; response as in Sykulski et al. 2019, "debiased Whittle"). The
/// quasi-score of the joint covariance refines the maximum and gives the covariance of the parameters
/// (McCullagh and Nelder 1989, 9.3); it reduces errors by 1-4 %.
/// Intervals are Wald's in the logarithm (power-law exponent: in itself). The response accounts for the
/// height that detrending removes from the lowest bins; bins below 1.5 resolutions are not used.
/// kAuto takes the simplest family within 2 of the least criterion, among those whose parameters the data
/// determine. It chooses among all families if only then a model describes the data (`goodness`).
/// If that fit fails (goodness below 1e-3), it is repeated once from the least squares of the logarithms. If
/// it fails again, a model error is allowed: log psd = log E + sampling error + d, where d has standard
/// deviation tau (`model_error`) and correlation exp(-|log f - log f'| / L). The fit is then least squares of
/// the logarithms (bias of log chi-squared removed) with weights 1 / (psi'(dof / 2) + tau^2), so that all
/// decades count. tau and L follow from restricted maximum likelihood (random effects; Patterson and Thompson
/// 1971), the covariance from the sandwich of these weights for bins with that correlation. `log_likelihood`
/// and `criterion` are then those of normal log bins, each family with its own tau. kAuto takes a family with
/// undetermined parameters only if its criterion is better by more than 6. `goodness` stays the p-value
/// without model error, and the model follows the geometric mean of the bins.
/// If the limit of a family (knee outside the band, no floor) does as well at `confidence`, `family` is the
/// limit. The parameter is then not identified, and the profile likelihood only bounds it.
/// For a profile, a uniform surface is a disc of frequencies up to f_max. A floor is white noise of the
/// instrument, reported but not part of `model` (warning `floor-left-out`). With fewer usable bins than
/// parameters + 1 the status is kFailed with a message. Time: 1-10 ms per family, twice that with a model
/// error.
PsdModelFit fit_psd_model(const PsdEstimate& estimate, const PsdFitOptions& options = {});

}  // namespace aberfit
