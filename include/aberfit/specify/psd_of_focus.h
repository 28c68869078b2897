#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/measured/focal_data.h"
#include "aberfit/method/run_context.h"
#include "aberfit/specify/solve.h"

// From the light of a measured focus to the PSD that spreads it so.
namespace aberfit {

/// A measured focus and what is known of it.
struct MeasuredFocus {
  std::variant<EncircledCurve, FocalImage> data;
  double dz = 0;     ///< plane [m]
  double pixel = 0;  ///< side of the square pixels of an image, or that a curve was counted with; 0: none [m]
  double reach = 0;  ///< what is further from the centre is left out [m]; 0: nothing
  /// Standard deviation of a share [1], of a pixel [unit of the image]. Absent: as the curve's file says, of
  /// an image from its rim; where neither does, from the residuals, of one mirror no less than 0.001 of the
  /// light or of the brightest pixel, of a mean 0.0001.
  std::optional<double> noise;
  std::optional<double> gain;  ///< of an image: photoelectrons in its unit, which have shot noise
  bool is_total_known = true;  ///< of a curve: shares are of all of the light; else of an unknown part
  bool has_background = true;  ///< of an image: an even one is fitted
  /// One mirror was measured, whose own focus departs from the mean light of its specification; else a mean
  /// of many.
  bool is_one_mirror = true;
  double confidence = 0.95;  ///< of the intervals, in (0.5, 1)
};

/// One number of the PSD.
struct NumberOfFocus {
  SolveUnknown unknown;
  double best = 0;  ///< at the minimum [its SI unit]
  /// Standard deviation of its logarithm, by derivatives at the minimum; of a mean whose noise nobody knows
  /// wide enough for the fault (total, plane, centre, scale) that its residuals hide best.
  double log_std = 0;
  double lower = 0, upper = 0;  ///< profile likelihood interval; the end of the search where there is none
  bool lower_found = false, upper_found = false;
  bool identified() const { return lower_found && upper_found; }
};

enum class PsdOfFocusStatus {
  kFitted,
  kNotIdentified,  ///< the light does not determine one of the numbers, or a combination of them
  kNotDescribed,   ///< no such roughness spreads the light as it was measured
  kNotConverged,
};
std::string to_string(PsdOfFocusStatus status);

struct PsdOfFocus {
  std::string title;
  PsdOfFocusStatus status = PsdOfFocusStatus::kNotConverged;
  std::string message;  ///< why it is not fitted; else empty
  std::vector<NumberOfFocus> numbers;
  Eigen::MatrixXd correlation;  ///< of the logarithms of `numbers`
  double confidence = 0.95;
  bool is_image = false, is_one_mirror = true, is_noise_known = true;
  double total = 1;         ///< light that the mean light is multiplied with [unit of the data]
  double background = 0;    ///< of a pixel [unit of the image]
  double noise_factor = 1;  ///< of what was taken for the noise: root of chi_squared over degrees of freedom
  double chi_squared = 0;
  int degrees_of_freedom = 0;
  /// Chance of a larger chi_squared; where the noise was not known, that noise would have as much of the
  /// form that the residuals have.
  double goodness = 0;
  double dz = 0;                      ///< [m]
  double centre_x = 0, centre_y = 0;  ///< of an image [pixels, from its lower left one]
  Eigen::ArrayXd radius;              ///< of a circle, or mean one of a ring's pixels [m]; ascending
  Eigen::ArrayXd measured, fitted;    ///< share within it, or mean light of a pixel of the ring
  Eigen::ArrayXd noise;               ///< standard deviations of `measured`, without the mirror's own
  Eigen::ArrayXd
      spread;  ///< standard deviation of one mirror's light about the mean; 0 where many were measured
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Weighted least squares of the light that the mean spot of generalised Harvey-Shack has in each circle or
/// ring (pixels exactly, of light that is symmetric about its centre), over the logarithms of the unknowns,
/// with exact derivatives (theory/psd_jacobian.h). Known aberrations are those of the task's mirror.
///
/// Of one mirror, deviations from the mean light count as noise with the covariance that theory gives them
/// (`RealisationSpread::covariance`). They are
/// those of `mirrors_at`, the task without what is averaged over within an exposure (air, jitter): more than
/// the blurred light has.
/// A number is identified where the profile of the sum of squares rises to the confidence on both sides
/// within a factor of 1000 of its start, of exponents 10. Warnings `not-identified`, `poor-fit`: goodness
/// below 1e-3, or, of a noise that nobody knows, below 0.02. Then the likelihood is asked whether part of all
/// light, another plane, another centre or another scale of the radii, or anything smooth along the curve
/// would leave residuals of less form, and the message has the remedy of the one that does best. Throws
/// FieldError for data and starts that cannot be used, ComputationError where the start has no prediction.
PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const TaskAt& mirrors_at,
                            const std::vector<SolveUnknown>& unknowns, const MeasuredFocus& focus,
                            const RunContext& context);
/// Of a task that stands still.
PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                            const MeasuredFocus& focus, const RunContext& context);

}  // namespace aberfit
