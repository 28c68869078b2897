#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/forward/forward_model.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_spectrum.h"

namespace aberfit {

/// The problem: coefficients of `light.surface.terms()` for which the statistics of the traced surface meet
/// the targets, and the surface's own PSD the spectral ones. Either kind may be absent.
struct FitProblem {
  LightPath light;  ///< mirror, pupil and surface of the statistics; a fit uses its own workspace
  const CoefficientPrior& prior;  ///< whitens the coefficients
  std::vector<Target> targets;
  /// Statistics between the targets. They pull with their own, wider tolerance but do not have to meet it.
  /// Without them the EE curve varies between the fitted fractions and planes as much as between realisations
  /// (see `kGuideShareOfMargin` in method/constants.h).
  std::vector<Target> guides;
  double focal_sigma = 0;  ///< scale of the focal spot [m]; smoothing widths are multiples of it
  /// PSD bins of the surface as further targets; null: none. Residuals: log(S_b(c) / T_b) / tolerance_b. S_b
  /// is the surface's own bin, not a noisy estimate, so its logarithm has no bias.
  const SurfaceSpectrum* spectrum = nullptr;
  Eigen::VectorXd spectrum_target = {};  ///< [m^4], positive, one per bin
  Eigen::VectorXd spectrum_tolerance =
      {};  ///< tolerance of the natural logarithm of the PSD, positive, one per bin
};

enum class PriorMode {
  kNearStart,  ///< |xi - xi0|^2: the surface nearest to the seeded random start; keeps its character
  kZeroMean,   ///< |xi|^2: calibration of few or low-order terms
};

struct FitProgress {
  int iteration = 0;
  double cost = 0;            ///< half the sum of squared residuals
  double worst_mismatch = 0;  ///< largest |S - T| / tolerance over the targets, log PSD bins included
  double seconds = 0;
  int solve = 0;  ///< index of the smoothing; mismatches of different smoothings are not comparable
};

/// Settings of the fit.
struct FitOptions {
  PriorMode prior = PriorMode::kNearStart;
  int max_iterations = 100;
  std::vector<double> smoothing = {
      0.1, 0.005};  ///< kernel half-widths in units of focal_sigma, one solve each, coarse to fine
  /// The fit stops when every |S - T| <= stop_at * tolerance, log PSD bins included. It also stops when all
  /// tolerances are met and the worst mismatch no longer falls, because solvers otherwise creep along the
  /// prior. Met tolerances give kConverged either way.
  double stop_at = 0.5;
  /// Factor on the prior's residuals xi - xi0 (or xi) in the solve. Below 1 the targets pull harder than
  /// against the full prior, and a fit of few terms ends sooner. The posterior always uses 1.
  double prior_weight = 1;
  /// Above 0: a guide is met within this many of its tolerances, and the fit goes on until all guides are.
  double guides_within = 0;
  /// Steps follow the curved valley of the targets (geodesic acceleration) at one more evaluation each. Waves
  /// only: the narrow kernels of rays gain nothing. The gain is largest where terms far outnumber statistics.
  bool accelerate = true;
  double bound = 0;  ///< > 0: |xi_i| <= bound, in prior standard deviations
  int threads = 1;
  std::function<bool(const FitProgress&)> progress;  ///< called after every iteration; false cancels
};

/// kConverged: every tolerance is met, or the cost is at a minimum with all within ten of them.
enum class FitStatus { kNotRun, kConverged, kNotConverged, kDegenerate, kCancelled, kFailed };
std::string to_string(FitStatus status);

/// The result of a fit.
struct FitResult {
  FitStatus status = FitStatus::kNotRun;
  std::string message;  ///< the reason it stopped, one sentence
  int iterations = 0;
  int evaluations = 0;
  bool out_of_iterations = false;  ///< FitOptions::max_iterations ended it
  double seconds = 0;
  double initial_cost = 0, final_cost = 0;
  OperatorChoice operator_choice;     ///< how L was computed
  Eigen::VectorXd white;              ///< xi
  Eigen::VectorXd coefficients;       ///< F xi [m]
  Eigen::VectorXd smooth_statistics;  ///< the smooth twins at the solution, in target order
  Eigen::VectorXd spectrum;           ///< PSD bins at the solution [m^4]; empty without spectral targets
  // Posterior of the linearised problem: tolerances are the noise of targets, guides and log PSD bins.
  Eigen::VectorXd coefficient_std;  ///< [m]
  Eigen::VectorXd statistic_std;    ///< posterior standard deviation of each predicted statistic
  Eigen::VectorXd singular_values;  ///< of the whitened residual Jacobian, descending
  int rank = 0;  ///< number of directions that targets determine better than the prior: singular value > 1
  int null_directions = 0;  ///< terms - numerical rank: directions without effect on the targets
};

/// Solves for the coefficients with Ceres and exact derivatives through L, the trace and the smooth
/// statistics, at a cost near linear in rays and terms. Residuals: (S_k - T_k) / tolerance_k, log(S_b / T_b)
/// / tolerance_b, and xi - xi0 (or xi). start: white coordinates. The whitened problem is identity plus low
/// rank. The trust region works in the span of the Jacobian's rows, which contains all its steps, renewed
/// after every step. Bounded problems use conjugate gradients on all coefficients. Every solve but the last
/// stops at three tolerances. Diffraction smooths by itself: unless kRays there is one solve, with the last
/// of `smoothing` for the ray statistics.
/// kDegenerate: a statistic or a log PSD bin has no value or derivative at the start. By waves three more
/// cases give it. An EE radius may be smaller than that of the perfect mirror by more than 2 % and its
/// tolerance. It may lie outside the field of view of the pupil grid. All coefficients may be zero, where
/// nothing changes to first order. Throws std::invalid_argument for spectral targets that do not fit the
/// spectrum's bins or are not positive, and for scenes that focus_statistics refuses.
FitResult calibrate(const FitProblem& problem, const Eigen::VectorXd& start, const FitOptions& options);

/// True when every smooth statistic and log PSD bin of `result` is within `share` times its tolerance.
bool within_tolerance(const FitProblem& problem, const FitResult& result, double share);

/// Version of the linked Ceres library.
std::string solver_version();

}  // namespace aberfit
