#pragma once
#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit {

/// PSD of the surface in the bins of an estimate, without effects of the estimator (leakage, holes,
/// detrending, uneven pitch): psd S(f) / (response S), since E[psd] = response S. The fitted model gives the
/// shape S.
struct SurfacePsd {
  Eigen::ArrayXd frequency, low, high;  ///< of the bins, as in the estimate [cycles/m]
  Eigen::ArrayXd psd, lower, upper;     ///< PSD at `frequency` with its interval [m^3 or m^4]
  Eigen::ArrayXd dof;
  Eigen::ArrayXd model;  ///< S of the fitted model at `frequency` [m^3 or m^4]
  /// Ratio to the PSD of the estimate. Bins outside 1/2 .. 2 depend more on the estimator than on the surface
  /// and are dropped, as are those outside `trusted_from` .. `trusted_to` or the band of the fit.
  Eigen::ArrayXd factor;
  std::vector<Eigen::Index> bin;  ///< index of each remaining bin in the estimate
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< band of the fit [cycles/m]
};

/// If the fit failed, S is taken as constant and `model` is NaN.
SurfacePsd surface_psd(const PsdEstimate& estimate, const PsdModelFit& fit);

/// RMS height and slope in a band.
struct BandRms {
  double height = 0;  ///< [m]
  /// RMS slope [rad]; profiles: along the profile; maps: per axis, root of the mean of both mean squares
  double slope = 0;
};
/// Returns the RMS of the bins between f_min and f_max, or of the model in the same bins. Inside a bin the
/// PSD follows the power law of the decade around it. A frequency counts in the first bin that holds it, not
/// at all in a gap between bins. Zero if the band meets no bin.
BandRms rms_in_band(const SurfacePsd& surface, PsdTableKind kind, bool of_model, double f_min, double f_max);

/// A named band of spatial frequencies, such as the mid frequencies of a telescope mirror.
struct FrequencyBand {
  std::string name;
  double f_min = 0, f_max = 0;  ///< [cycles/m]
};
/// RMS values of a named band.
struct BandContent {
  FrequencyBand band;
  /// part of the band that has bins in the band of the fit [cycles/m]; both 0: none
  double from = 0, to = 0;
  BandRms data, model;
};
BandContent band_content(const SurfacePsd& surface, PsdTableKind kind, const FrequencyBand& band);
/// Returns the content of every octave from 2^k to 2^(k+1) cycles/m that the bins reach; `name` is empty.
std::vector<BandContent> octaves(const SurfacePsd& surface, PsdTableKind kind);

/// Profile PSD A / f^B over a band, the form of drawings (ISO 10110-8).
struct DrawingLine {
  double exponent = 0, exponent_std = 0;        ///< B
  double amplitude = 0, log_amplitude_std = 0;  ///< A [m^(3-B)]; f in cycles/m
  double f_min = 0, f_max = 0;                  ///< [cycles/m]
  double confidence = 0;                        ///< confidence level of the interval of B
  double lower = 0, upper = 0;                  ///< interval of B
  double factor = 1;                            ///< RMS height of the line over that of the bins, in the band
  bool describes = true;  ///< true: the deviations from the bins are consistent with chance
};
/// Fits the power law to the bins in [f_min, f_max] by maximum likelihood with the response (fit_psd_model);
/// for maps, that of their profiles. `exponent` is NaN if the profile PSD diverges or there are too few bins.
DrawingLine drawing_line(const PsdEstimate& estimate, double f_min, double f_max);

/// Returns the power law with the RMS height and slope of the bins in [f_min, f_max] (method of moments), for
/// maps that of their profiles. It reproduces the focus of this surface, whose few lowest bins may deviate
/// from the most likely line. No intervals; `exponent` is NaN if none has that ratio of slope to height.
DrawingLine line_as_measured(const SurfacePsd& surface, PsdTableKind kind, double f_min, double f_max);

}  // namespace aberfit
