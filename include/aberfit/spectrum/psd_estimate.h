#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/spectrum/detrend.h"

namespace aberfit {

enum class WindowKind { kNone, kHann, kHamming, kBlackmanHarris, kWelch, kTukey };
std::string to_string(WindowKind window);
/// Returns the window at (i + 1/2)/n, i = 0 .. n-1. Tukey tapers a quarter of the length at either end.
Eigen::ArrayXd window_values(WindowKind window, Eigen::Index n);

/// Options of an estimate, stored with it so that a model or another surface can be processed alike.
struct PsdEstimatorOptions {
  DetrendOptions detrend;
  WindowKind window = WindowKind::kHann;
  int bins_per_decade = 12;  ///< logarithmic bins; each holds at least one ordinate
  double confidence = 0.95;  ///< confidence level of the intervals
  bool find_lines = true;    ///< exclude periodic structure from the bins and report it as lines
};

/// Periodic structure above the continuum: turning marks, gratings, vibration.
struct SpectralLine {
  double frequency = 0;  ///< [cycles/m]
  double angle =
      0;  ///< maps: direction of the wave vector [rad], 0..pi; NaN for a ring (turning marks) or a profile
  double rms = 0;          ///< RMS height of the structure, continuum subtracted [m]
  double strength = 0;     ///< ratio of the peak to the local continuum
  double false_alarm = 0;  ///< probability of such a peak anywhere in a spectrum without lines
};

/// PSD in logarithmic bins, with the response and covariance needed to compare a model with it.
struct PsdEstimate {
  PsdTableKind kind =
      PsdTableKind::k2dTwoSided;  ///< profile: one-sided S1 [m^3]; map: radially averaged two-sided S2 [m^4]
  Eigen::ArrayXd frequency;       ///< mean frequency of the ordinates in each bin [cycles/m], ascending
  Eigen::ArrayXd low, high;       ///< bin edges [cycles/m]
  Eigen::ArrayXd psd;             ///< mean of the periodogram ordinates [m^3 or m^4]
  Eigen::ArrayXd count;           ///< number of ordinates averaged
  Eigen::ArrayXd
      dof;  ///< effective degrees of freedom: psd ~ E chi^2_dof / dof; 2 / relative_covariance(b, b)
  Eigen::ArrayXd lower, upper;  ///< chi-squared confidence interval of the mean level [m^3 or m^4]
  /// Expectation of the estimator: E[psd] = response * S(node_frequency), S of the same kind as psd. It
  /// includes leakage, holes, detrending, uneven pitch, integration of slopes and excluded lines.
  Eigen::ArrayXd node_frequency;
  Eigen::MatrixXd response;  ///< bins x nodes
  /// cov(psd_b, psd_c) = relative_covariance(b, c) E_b E_c. It is 2 / (n_b n_c) times the sum over all pairs
  /// of ordinates of both bins (numbers n_b, n_c with conjugates) of |sum w^2 exp(2 pi i d t)|^2 / (sum
  /// w^2)^2, where d is their distance. For the Hann window this is 1, 4/9, 1/36 per axis for d = 0, 1, 2.
  /// The lowest ordinates (profiles: 8, maps: 3 steps) include the effect of detrending.
  Eigen::MatrixXd relative_covariance;
  std::vector<SpectralLine> lines;
  PsdEstimatorOptions options;
  /// RMS of the detrended heights without window, each valid sample once [m]; slopes are first integrated
  /// (trapezoid rule, true positions). Maps: all valid points, also those outside the rectangle of the PSD.
  double rms_height = 0;
  /// RMS slope of the detrended surface. Slope data: slopes minus the derivative of the shape of the heights.
  /// Height data: second-order differences on the true positions (one-sided at the ends) where all neighbours
  /// are valid. Maps: central differences per axis; the root of the mean of both mean squares.
  double rms_slope = 0;
  /// Maps: RMS slopes along x and along y; NaN for profiles.
  double rms_slope_x = std::numeric_limits<double>::quiet_NaN();
  double rms_slope_y = std::numeric_limits<double>::quiet_NaN();
  /// RMS of slope data detrended by their own polynomial, one degree below that of heights; NaN for heights.
  double rms_slope_as_slopes = std::numeric_limits<double>::quiet_NaN();
  double resolution = 0;  ///< frequency step of the ordinates [cycles/m]
  double nyquist = 0;     ///< [cycles/m]
  /// Upper limit of usable bins [cycles/m]: beyond, the PSD falls more steeply than that of any surface,
  /// because the instrument or a filter ends. Infinite without a limit, else warning `instrument-cut-off`.
  double trusted_to = std::numeric_limits<double>::infinity();
  /// Lower limit of usable bins [cycles/m]: below, leakage of a shape left by detrending exceeds the
  /// roughness. 0 without a limit; otherwise warning `shape-leaks`.
  double trusted_from = 0;
  Warnings warnings;
};

/// `rms_height` and the RMS slopes as above, without a PSD.
struct SurfaceRms {
  double height = 0;  ///< [m]
  double slope = 0;   ///< maps: per axis, the root of the mean of the squares of slope_x and slope_y
  double slope_x = std::numeric_limits<double>::quiet_NaN();  ///< maps only
  double slope_y = std::numeric_limits<double>::quiet_NaN();
};
SurfaceRms surface_rms(const Profile& profile, const DetrendOptions& detrend);
SurfaceRms surface_rms(const HeightMap& map, const DetrendOptions& detrend);

/// An estimator for one geometry (positions, valid points), reusable for many surfaces. The response is
/// computed once, and again for a surface with lines, whose ordinates are excluded.
/// Profiles: slopes are integrated (trapezoid rule), heights are detrended, holes bridged linearly, and an
/// uneven pitch is resampled by a cubic spline.
/// Maps: the PSD uses the largest axis-aligned rectangle without a point outside the outline. Outside are
/// invalid points connected to the edge of the grid along rows and columns, and any hole larger than 5 % of
/// the rectangle, after which the rectangle is searched again. Of equal areas, the one with the lowest last
/// row, then last column, is used. Each side is cut to the next lower product of 2, 3, 5, 7; half of the
/// loss, rounded down, is at its low end. There the shape is fitted to the valid points and subtracted. Each
/// hole point becomes the mean of its neighbours in row and column, weighted by 1/pitch^2 (a harmonic
/// bridge).
/// Periodogram: separable window, sample i at (i + 1/2)/n of its length; |FFT|^2 over the sum of the squared
/// window, times the area of a point (profiles: 2 pitch). Bins reach from the lowest ordinate to below the
/// (smaller) Nyquist frequency, with edges at resolution 10^((k - 1/2)/bins_per_decade) for whole k. The
/// ordinates 0 and Nyquist are not used.
/// The response assumes no surface beyond Nyquist (aliasing) and none below resolution/16; for large maps
/// with holes its error near Nyquist is up to 0.6 %. An ellipse enters it as a polynomial of degree 4. If no
/// ellipse fits (a plane), a parabola is subtracted and noted in `options`, with the warning
/// `ellipse-fit-failed`.
/// relative_covariance is that of the window, for the lowest ordinates with detrending; leakage of a red
/// spectrum without window correlates bins more. Throws std::invalid_argument like estimate_psd.
class PsdEstimator {
 public:
  PsdEstimator(const Profile& geometry, const PsdEstimatorOptions& options, int threads = 1);
  PsdEstimator(const HeightMap& geometry, const PsdEstimatorOptions& options, int threads = 1);
  ~PsdEstimator();
  PsdEstimator(PsdEstimator&&) noexcept;
  PsdEstimator& operator=(PsdEstimator&&) noexcept;

  /// Returns the PSD of a profile or map of exactly this geometry.
  PsdEstimate operator()(const Profile& profile) const;
  PsdEstimate operator()(const HeightMap& map) const;

 private:
  template <class Measured>
  void trust_from_the_shape(const Measured& measured, const std::vector<char>& left_out,
                            PsdEstimate* result) const;
  struct Plan;
  std::unique_ptr<const Plan> plan_;
};

/// Estimates one PSD. Throws std::invalid_argument below 16 valid samples (4 x 4 points) or without pitch.
PsdEstimate estimate_psd(const Profile& profile, const PsdEstimatorOptions& options, int threads = 1);
PsdEstimate estimate_psd(const HeightMap& map, const PsdEstimatorOptions& options, int threads = 1);

/// Combines the bands of several instruments, all of one kind, into one PSD. Where bands overlap, the bins
/// with more degrees of freedom are used. Bins keep their response and covariance (in blocks); those outside
/// `trusted_from` .. `trusted_to` are dropped. Warning `bands-disagree` if intervals of overlapping bins are
/// disjoint.
PsdEstimate stitch(const std::vector<PsdEstimate>& bands);

}  // namespace aberfit
