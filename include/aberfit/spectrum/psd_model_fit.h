#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {

/// Shapes of PSD that can be fitted. In one dimension (profiles) the fitted function is the profile PSD of
/// the isotropic surface.
enum class PsdFamily {
  kAuto,  ///< all of the others, chosen by the information criterion
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
  double f_min = 0, f_max = 0;  ///< bins to use [cycles/m]; 0: all that are trusted (see fit_psd_model)
  double confidence = 0.95;
  int max_iterations = 200;
};

/// Goodness below which a model does not describe its bins.
inline constexpr double kPoorFit = 1e-3;

/// One number of a fitted model.
struct PsdParameter {
  std::string name;  ///< "rms", "B", "exponent", "amplitude", "floor", ...; exponent is 2-D
  std::string unit;  ///< SI
  double value = 0, std = 0;
  double lower = 0, upper = 0;  ///< confidence interval; may be asymmetric
  bool identified =
      true;  ///< false: the data do not determine it; value is NaN and a bound or nothing is known
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
  PsdModel model;  ///< two-dimensional, two-sided surface PSD in the band of the bins used: ready for a
                   ///< study; floor left out where it is noise of a profile
  std::vector<PsdParameter> parameters;
  Eigen::MatrixXd covariance;   ///< of the internal (log) parameters, sandwich form
  double f_min = 0, f_max = 0;  ///< band used [cycles/m]
  Eigen::ArrayXd expected;      ///< E[psd] of the model at every bin of the estimate
  Eigen::ArrayXd spectrum;      ///< the model itself at the bins' frequencies, of the kind of the estimate
  TablePsd curve;               ///< the same over the band, dense: log-log within 1e-3 of its integrals
  double log_likelihood = 0, criterion = 0;
  double goodness = 0;     ///< p-value of the residuals, given the model
  double model_error = 0;  ///< tau: relative model discrepancy allowed for beside the sampling error; 0 where
                           ///< the model describes the bins
  std::vector<PsdCandidate> candidates;
  Warnings warnings;  ///< `not-identified`, `poor-fit`, ...
};

/// Fits PSD models to the bins of an estimate by the Whittle (gamma) likelihood of chi-squared bins, E =
/// response * S: no logarithm, so no log bias (Whittle 1953; response as in Sykulski et al. 2019, "debiased
/// Whittle"). The maximum is refined by the quasi-score of the bins' joint covariance (McCullagh and Nelder
/// 1989, 9.3), which also gives the covariance of the parameters; 1-4 % smaller errors than without.
/// Intervals are Wald's in the logarithm (power-law exponent: in itself). The lowest bins, which detrending
/// took height from, are weighted through the response; bins below 1.5 resolutions are left out. kAuto takes
/// the simplest family within 2 of the least criterion among those whose every parameter the data determine,
/// or among all where only then the model describes the data (`goodness`).
/// Where that fit fails to describe the bins (goodness below 1e-3) it is tried once more from the least
/// squares of the logs, and if that fails too, a model error is allowed for: log psd = log E + sampling error
/// + d, d of standard deviation tau (`model_error`) and correlation exp(-|log f - log f'| / L). The fit is
/// then least squares of the logs (bias of log chi-squared taken off) with weights 1 / (psi'(dof / 2) +
/// tau^2), so that all decades count; tau and L are estimated by restricted maximum likelihood (random
/// effects; Patterson and Thompson 1971), and the covariance is the sandwich of these weights between bins so
/// correlated. `log_likelihood` and `criterion` are then those of normal log bins, each family with its own
/// tau, and kAuto takes a family with undetermined parameters only if it wins by more than 6 of the
/// criterion; `goodness` stays the p-value without allowance, and the model follows the geometric middle of
/// the bins. A family whose limit (knee outside the band, no floor) does as well at `confidence` is given up
/// for that limit: `family` says so, the parameter is not identified and bounded by the profile likelihood.
/// Over a profile a uniform surface is a disc of frequencies that ends at f_max; a floor is white noise of
/// the instrument, reported and left out of `model` (warning `floor-left-out`). Fewer usable bins than
/// parameters + 1: kFailed with a message. About 1-10 ms a family, twice that with a model error.
PsdModelFit fit_psd_model(const PsdEstimate& estimate, const PsdFitOptions& options = {});

}  // namespace aberfit
