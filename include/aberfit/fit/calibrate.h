#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/forward/forward_model.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_spectrum.h"

namespace aberfit {

/// What is fitted: coefficients of `light.surface.terms()` such that the statistics of the traced surface
/// meet the targets, and the surface's own PSD the spectral ones. Either kind may be absent.
struct FitProblem {
  LightPath light;                ///< to what the statistics are of; a fit has a workspace of its own
  const CoefficientPrior& prior;  ///< whitens the coefficients
  std::vector<Target> targets;
  /// Statistics between the targets that only guide: they pull with their own, wider tolerance, but are not
  /// asked to meet it. Without them the EE curve is free to wander between the fitted fractions and planes by
  /// what realisations differ (see `kGuideShareOfMargin` in method/constants.h).
  std::vector<Target> guides;
  double focal_sigma = 0;  ///< scale of the focal spot [m]; smoothing widths are multiples of it
  /// PSD bins of the surface as targets beside the statistics; null: none. Residuals: log(S_b(c) / T_b) /
  /// tolerance_b. S_b is the surface's own bin, not a noisy estimate, so its logarithm has no bias.
  const SurfaceSpectrum* spectrum = nullptr;
  Eigen::VectorXd spectrum_target = {};     ///< [m^4], positive, one per bin
  Eigen::VectorXd spectrum_tolerance = {};  ///< of the natural logarithm of the PSD, positive, one per bin
};

enum class PriorMode {
  kNearStart,  ///< |xi - xi0|^2: the surface nearest to the seeded draw that hits the targets, keeps its
               ///< roughness character
  kZeroMean,   ///< |xi|^2: calibration of few or low-order terms
};

struct FitProgress {
  int iteration = 0;
  double cost = 0;            ///< half the sum of squared residuals
  double worst_mismatch = 0;  ///< largest |S - T| / tolerance over the targets, log PSD bins included
  double seconds = 0;
  int solve = 0;  ///< which of the smoothings: the mismatch of another is another
};

/// How it is fitted.
struct FitOptions {
  PriorMode prior = PriorMode::kNearStart;
  int max_iterations = 100;
  std::vector<double> smoothing = {
      0.1, 0.005};  ///< kernel half-widths in units of focal_sigma, one solve each, coarse to fine
  /// Stop when every |S - T| <= stop_at * tolerance, log PSD bins included, or when all tolerances are met
  /// and the worst mismatch has stopped falling; solvers otherwise creep along the prior. Met tolerances are
  /// kConverged either way.
  double stop_at = 0.5;
  /// Factor on the prior's residuals xi - xi0 (or xi) in the solve. Below 1 the targets pull harder than the
  /// prior's own standard deviations would let them: a fit of few terms, which the prior keeps at the edge of
  /// the tolerances, ends sooner. The posterior is that of 1.
  double prior_weight = 1;
  /// When above 0: a guide counts as met within so many of its tolerances, and the fit goes on until all are.
  double guides_within = 0;
  /// Steps follow the bend of the valley that the targets leave (geodesic acceleration), for one more
  /// evaluation each: waves only, whose statistics are smooth. Thirty iterations come down to nine where
  /// there are far more terms than statistics, 131 to 22 where there are as many; rays, with their narrow
  /// kernels, gain nothing.
  bool accelerate = true;
  double bound = 0;  ///< when > 0: |xi_i| <= bound, coefficients within so many prior standard deviations
  int threads = 1;
  std::function<bool(const FitProgress&)> progress;  ///< called after every iteration; false cancels
};

/// kConverged: every tolerance is met, or the cost is at a minimum with all within ten of them.
enum class FitStatus { kNotRun, kConverged, kNotConverged, kDegenerate, kCancelled, kFailed };
std::string to_string(FitStatus status);

/// What came.
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
  // Posterior of the linearised problem (tolerances as noise of targets, guides and log PSD bins, prior as
  // prior):
  Eigen::VectorXd coefficient_std;  ///< [m]
  Eigen::VectorXd statistic_std;    ///< posterior standard deviation of each predicted statistic
  Eigen::VectorXd singular_values;  ///< of the whitened residual Jacobian, descending
  int rank = 0;  ///< directions of coefficient space that the targets determine better than the prior
                 ///< (singular value > 1)
  int null_directions = 0;  ///< terms - numerical rank: directions the targets do not see at all
};

/// Solves for the coefficients with Ceres and exact derivatives through L, the trace and the smooth
/// statistics, at a cost near linear in rays and terms. The problem is whitened, identity plus low rank: the
/// trust region works in the span of the Jacobian's rows, where all its steps lie, and which is made anew at
/// every surface that a step leads to; with bounds on all coefficients by conjugate gradients. Solves but the
/// last one stop at three tolerances. start: white coordinates. Residuals: (S_k - T_k) / tolerance_k, log(S_b
/// / T_b) / tolerance_b, and xi - xi0 (or xi). kDegenerate where a statistic or a log PSD bin has no value or
/// derivative at the start, and unless kRays where an EE radius lies below that of the perfect mirror's
/// pattern (by more than 2 % and its tolerance), outside the field of view of the pupil grid, or nothing
/// changes to first order (zero coefficients). Diffraction smooths by itself: unless kRays one solve, with
/// the last of `smoothing` for what rays give. Throws std::invalid_argument for spectral targets that do not
/// fit the spectrum's bins or are not positive, and for scenes that focus_statistics refuses.
FitResult calibrate(const FitProblem& problem, const Eigen::VectorXd& start, const FitOptions& options);

/// Whether every smooth statistic and log PSD bin of `result` is within `share` of its tolerance.
bool within_tolerance(const FitProblem& problem, const FitResult& result, double share);

/// Version of the Ceres library this one was built with.
std::string solver_version();

}  // namespace aberfit
