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
/// Its values at (i + 1/2)/n, i = 0 .. n-1; Tukey with a quarter of the length tapered at either end.
Eigen::ArrayXd window_values(WindowKind window, Eigen::Index n);

/// How a PSD is estimated; part of every estimate, so that a model or another surface can go through the same
/// processing.
struct PsdEstimatorOptions {
  DetrendOptions detrend;
  WindowKind window = WindowKind::kHann;
  int bins_per_decade = 12;  ///< log bins; a bin holds at least one ordinate
  double confidence = 0.95;  ///< of the intervals
  bool find_lines = true;    ///< periodic structure is taken out of the bins and reported as lines
};

/// Periodic structure that stands out of the continuum: turning marks, gratings, vibration.
struct SpectralLine {
  double frequency = 0;  ///< [cycles/m]
  double angle =
      0;  ///< maps: direction of the wave vector [rad], 0..pi; NaN for a ring (turning marks) or a profile
  double rms = 0;          ///< RMS height of the structure [m], continuum subtracted
  double strength = 0;     ///< peak over local continuum
  double false_alarm = 0;  ///< probability of such a peak anywhere in a spectrum without lines
};

/// PSD in logarithmic bins, with all that is needed to compare a model with it.
struct PsdEstimate {
  PsdTableKind kind =
      PsdTableKind::k2dTwoSided;  ///< profile: one-sided S1 [m^3]; map: radially averaged two-sided S2 [m^4]
  Eigen::ArrayXd frequency;       ///< of the bins: mean over their ordinates [cycles/m], ascending
  Eigen::ArrayXd low, high;       ///< edges [cycles/m]
  Eigen::ArrayXd psd;             ///< mean of the periodogram ordinates [m^3 or m^4]
  Eigen::ArrayXd count;           ///< ordinates averaged
  Eigen::ArrayXd
      dof;  ///< effective degrees of freedom: psd ~ E chi^2_dof / dof; 2 / relative_covariance(b, b)
  Eigen::ArrayXd lower, upper;  ///< confidence interval of the mean level, chi-squared [m^3 or m^4]
  /// Expectation of the estimator: E[psd] = response * S(node_frequency), S of the same kind as psd. Holds
  /// leakage, holes, detrending, uneven pitch, integration of slopes and excluded lines.
  Eigen::ArrayXd node_frequency;
  Eigen::MatrixXd response;  ///< bins x nodes
  /// cov(psd_b, psd_c) = relative_covariance(b, c) E_b E_c: 2 / (n_b n_c) times the sum over all pairs of
  /// ordinates of both bins (n_b, n_c of them, conjugates counted) of |sum w^2 exp(2 pi i d t)|^2 /
  /// (sum w^2)^2, d: their distance; of Hann's window 1, 4/9, 1/36 per axis for d = 0, 1, 2. The lowest
  /// ordinates (profiles: 8, maps: 3 steps) feel the detrending, too.
  Eigen::MatrixXd relative_covariance;
  std::vector<SpectralLine> lines;
  PsdEstimatorOptions options;
  /// Of the detrended heights, unwindowed, each valid sample once [m]. Slopes become heights by the trapezoid
  /// rule on the true positions first. Maps: of all valid points, also those outside the estimated rectangle.
  double rms_height = 0;
  /// Of the gradient of the detrended surface. Slope data: the slopes minus the derivative of the shape that
  /// is taken off the heights. Height data: derivative of the detrended heights, second-order differences on
  /// the true positions (one-sided at both ends) where all neighbours are valid. Maps: per axis, central
  /// differences at points that are valid like both their neighbours; root of the mean of both axes' mean
  /// squares.
  double rms_slope = 0;
  /// Maps: those root mean squares along x and along y; NaN for profiles.
  double rms_slope_x = std::numeric_limits<double>::quiet_NaN();
  double rms_slope_y = std::numeric_limits<double>::quiet_NaN();
  /// Slope data in the other convention, detrended as slopes: minus their own polynomial, one degree less
  /// than the heights'. NaN for heights.
  double rms_slope_as_slopes = std::numeric_limits<double>::quiet_NaN();
  double resolution = 0;  ///< frequency step of the ordinates [cycles/m]
  double nyquist = 0;     ///< [cycles/m]
  /// Bins beyond fall off a cliff, as no surface does: the transfer of the instrument, or a filter, ends
  /// there [cycles/m]; infinite where there is none. With it comes the warning `instrument-cut-off`.
  double trusted_to = std::numeric_limits<double>::infinity();
  /// Bins below hold more of a shape that detrending has left than of the roughness [cycles/m]; 0 where there
  /// is none. With it comes the warning `shape-leaks`.
  double trusted_from = 0;
  Warnings warnings;
};

/// `rms_height` and the RMS slopes as above, without a PSD.
struct SurfaceRms {
  double height = 0;  ///< [m]
  double slope = 0;   ///< of a map per axis: root of the mean square of the next two
  double slope_x = std::numeric_limits<double>::quiet_NaN();  ///< maps only
  double slope_y = std::numeric_limits<double>::quiet_NaN();
};
SurfaceRms surface_rms(const Profile& profile, const DetrendOptions& detrend);
SurfaceRms surface_rms(const HeightMap& map, const DetrendOptions& detrend);

/// An estimator for one geometry (positions, valid points), reusable for many surfaces of that geometry: the
/// response is worked out once (again for a surface with lines, whose ordinates are left out).
/// Profiles: heights (trapezoid rule), detrended, holes bridged linearly, uneven pitch resampled by a cubic
/// spline. Maps: largest axis-aligned rectangle without a point outside the outline (outside: invalid points
/// that steps along rows and columns over invalid points join to the edge of the grid, and holes that take
/// more than 5 % of the rectangle found with them inside, which is then looked for again; of equal areas the
/// one with the lowest last row, then last column). Each side is cut to the next lower product of 2, 3, 5, 7,
/// half of the loss, rounded down, at its low end; there the shape is fitted to the valid points and taken
/// off, then each hole becomes the mean of its neighbours in row and column, weighted by 1/pitch^2 (a
/// harmonic bridge). Then the (separable) window, sample i at (i + 1/2)/n of its length, |FFT|^2 over the sum
/// of the squared window, times the area of a point (profiles: 2 pitch), bins from the lowest ordinate to
/// below the (smaller) Nyquist frequency, edges at resolution 10^((k - 1/2)/bins_per_decade) for whole k; the
/// ordinates 0 and Nyquist are not used.
/// The response knows no surface beyond Nyquist (aliasing) nor below resolution/16; of large maps with holes
/// it was seen 0.6 % off near Nyquist. An ellipse enters it as a polynomial of degree 4; where none fits (a
/// plane), a parabola is taken off, `options` say so, and there is a warning `ellipse-fit-failed`.
/// relative_covariance is that of the window, of the lowest ordinates with detrending; leakage of a red
/// spectrum without window correlates bins more than it says. Throws std::invalid_argument like estimate_psd.
class PsdEstimator {
 public:
  PsdEstimator(const Profile& geometry, const PsdEstimatorOptions& options, int threads = 1);
  PsdEstimator(const HeightMap& geometry, const PsdEstimatorOptions& options, int threads = 1);
  ~PsdEstimator();
  PsdEstimator(PsdEstimator&&) noexcept;
  PsdEstimator& operator=(PsdEstimator&&) noexcept;

  /// The PSD of a profile or map of exactly this geometry.
  PsdEstimate operator()(const Profile& profile) const;
  PsdEstimate operator()(const HeightMap& map) const;

 private:
  template <class Measured>
  void trust_from_the_shape(const Measured& measured, const std::vector<char>& left_out,
                            PsdEstimate* result) const;
  struct Plan;
  std::unique_ptr<const Plan> plan_;
};

/// One call for one measurement. Throws std::invalid_argument when fewer than 16 valid samples (4 x 4 points)
/// remain or the pitch is unknown.
PsdEstimate estimate_psd(const Profile& profile, const PsdEstimatorOptions& options, int threads = 1);
PsdEstimate estimate_psd(const HeightMap& map, const PsdEstimatorOptions& options, int threads = 1);

/// Exponent and level of the straight line through log psd over log f (bins whose `frequency` lies in
/// [f_min, f_max], weighted by dof, the logarithm's bias psi(dof/2) - log(dof/2) taken off): psd ~ level (f /
/// 1 per m)^-exponent.
struct PsdSlope {
  double exponent = 0, exponent_std = 0;
  double level = 0;  ///< [m^3 or m^4] at 1 cycle/m
};
PsdSlope psd_slope(const PsdEstimate& estimate, double f_min, double f_max);

/// One PSD from several instruments' bands. All of one kind (convert first). Where bands overlap the bins of
/// the finer estimate (more degrees of freedom) win; bins keep their own response and covariance (blocks).
/// Bins beyond a band's `trusted_to` are left out.
/// Warning `bands-disagree` where overlapping levels differ by more than their intervals.
PsdEstimate stitch(const std::vector<PsdEstimate>& bands);

}  // namespace aberfit
