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

// Determines the PSD of a surface from its measured focus.
namespace aberfit {

/// A measured focus and what is known about the measurement.
struct MeasuredFocus {
  std::variant<EncircledCurve, FocalImage> data;
  double dz = 0;  ///< defocus of the measured plane [m]
  /// side of the square pixels of an image, or of those from which a curve was counted; 0: none [m]
  double pixel = 0;
  double reach = 0;  ///< data further from the centre are ignored [m]; 0: no limit
  /// Standard deviation of a fraction [1], or of a pixel [unit of the image]. If absent, it comes from the
  /// file of the curve or from the rim of the image. If neither has it, it comes from the residuals. It is
  /// then at least 0.001 of the energy or of the brightest pixel for one mirror, and 0.0001 for a mean.
  std::optional<double> noise;
  std::optional<double> gain;  ///< images: photoelectrons per unit, for the shot noise
  /// curves: true if the fractions refer to the whole energy, false if to an unknown part
  bool is_total_known = true;
  bool has_background = true;  ///< images: fit a uniform background
  /// true: one mirror, which deviates from the mean of its specification; false: a mean of many mirrors
  bool is_one_mirror = true;
  double confidence = 0.95;  ///< confidence level of the intervals, in (0.5, 1)
};

/// One fitted parameter of the PSD.
struct NumberOfFocus {
  SolveUnknown unknown;
  double best = 0;  ///< at the minimum [its SI unit]
  /// Standard deviation of its logarithm, from the derivatives at the minimum. For a mean with unknown noise
  /// it includes the systematic error (total, plane, centre, scale) that the residuals hide best.
  double log_std = 0;
  /// profile likelihood interval; the end of the search range if a bound is not found
  double lower = 0, upper = 0;
  bool lower_found = false, upper_found = false;
  bool identified() const { return lower_found && upper_found; }
};

enum class PsdOfFocusStatus {
  kFitted,
  kNotIdentified,  ///< the data do not determine a parameter, or a combination of parameters
  kNotDescribed,   ///< no such roughness explains the data
  kNotConverged,
};
std::string to_string(PsdOfFocusStatus status);

struct PsdOfFocus {
  std::string title;
  PsdOfFocusStatus status = PsdOfFocusStatus::kNotConverged;
  std::string message;  ///< reason if it is not fitted; otherwise empty
  std::vector<NumberOfFocus> numbers;
  Eigen::MatrixXd correlation;  ///< correlation of the logarithms of `numbers`
  double confidence = 0.95;
  bool is_image = false, is_one_mirror = true, is_noise_known = true;
  double total = 1;         ///< factor of the mean irradiance [unit of the data]
  double background = 0;    ///< per pixel [unit of the image]
  double noise_factor = 1;  ///< ratio of actual to assumed noise: root of chi_squared over degrees of freedom
  double chi_squared = 0;
  int degrees_of_freedom = 0;
  /// Probability of a larger chi_squared or, for unknown noise, of residuals with as much structure.
  double goodness = 0;
  double dz = 0;                      ///< [m]
  double centre_x = 0, centre_y = 0;  ///< images: centre of the spot [pixels from the lower left pixel]
  Eigen::ArrayXd radius;  ///< radius of a circle, or mean radius of the pixels of a ring [m]; ascending
  Eigen::ArrayXd measured, fitted;  ///< fraction within the radius, or mean irradiance of a pixel of the ring
  Eigen::ArrayXd noise;  ///< standard deviations of `measured`, without the deviation of one mirror
  Eigen::ArrayXd
      spread;  ///< standard deviation of one mirror's irradiance about the mean; 0 for a mean of many
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Weighted least squares of the energy in each circle or ring, over the logarithms of the unknowns, with
/// exact derivatives (theory/psd_jacobian.h). The model is the mean spot of generalised Harvey-Shack with the
/// aberrations of the task's mirror; pixels are integrated exactly for a spot that is symmetric about its
/// centre.
/// For one mirror, its deviation from the mean counts as noise with the theoretical covariance
/// (`RealisationSpread::covariance`) of `mirrors_at`. That is the task without what an exposure averages
/// (atmosphere, jitter), which would reduce the deviation.
/// A parameter is identified if the profile of the sum of squares reaches the confidence level on both sides,
/// within a factor of 1000 of its start (exponents: 10). Warnings: `not-identified`, and `poor-fit` for a
/// goodness below 1e-3 (unknown noise: 0.02). A poor fit is compared with part of the energy, another plane,
/// centre or scale of radii, and any smooth change along the curve; the message names the most likely one.
/// Throws FieldError for unusable data and starts, ComputationError if the start has no prediction.
PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const TaskAt& mirrors_at,
                            const std::vector<SolveUnknown>& unknowns, const MeasuredFocus& focus,
                            const RunContext& context);
/// The same with `mirrors_at` = `task_at`, for a task without averaging within an exposure.
PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                            const MeasuredFocus& focus, const RunContext& context);

}  // namespace aberfit
