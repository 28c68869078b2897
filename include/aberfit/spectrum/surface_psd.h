#pragma once
#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit {

/// The PSD of the surface itself in the bins of an estimate: what the estimator does to it (leakage, holes,
/// detrending, uneven pitch) divided out. E[psd] = response S, so that psd S(f) / (response S) is the
/// surface's where S has its shape within what a bin mixes; the shape is the fitted model's.
struct SurfacePsd {
  Eigen::ArrayXd frequency, low, high;  ///< of the bins, as in the estimate [cycles/m]
  Eigen::ArrayXd psd, lower, upper;     ///< at `frequency`, with intervals [m^3 or m^4]
  Eigen::ArrayXd dof;
  Eigen::ArrayXd model;  ///< S of the fitted model at `frequency` [m^3 or m^4]
  /// Over the estimate's; where it is not within 1/2 .. 2 the bin shows the estimator more than the surface
  /// and is left out of the arrays above, as is what lies outside `trusted_from` .. `trusted_to` and the
  /// band of the fit.
  Eigen::ArrayXd factor;
  std::vector<Eigen::Index> bin;  ///< index in the estimate of every bin that is here
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< band of the fit [cycles/m]
};

/// Where the fit failed the shape is constant and `model` NaN.
SurfacePsd surface_psd(const PsdEstimate& estimate, const PsdModelFit& fit);

/// RMS height and slope of what lies in a band.
struct BandRms {
  double height = 0;  ///< [m]
  double slope = 0;   ///< of profiles along them; of maps per axis, mean square of both [rad]
};
/// Of the bins between f_min and f_max, or of the model at the same bins. Within a bin the PSD falls as over
/// the decade around it, so that a band may end inside one. A frequency is part of the first bin here that
/// holds it, of none where the bins have a gap; zeros where the band meets no bin.
BandRms rms_in_band(const SurfacePsd& surface, PsdTableKind kind, bool of_model, double f_min, double f_max);

/// A band of spatial frequencies that has a name, such as the mid frequencies of a telescope's mirror.
struct FrequencyBand {
  std::string name;
  double f_min = 0, f_max = 0;  ///< [cycles/m]
};
/// What lies in it.
struct BandContent {
  FrequencyBand band;
  double from = 0, to = 0;  ///< the part that has bins, in the band of the fit [cycles/m]; both 0: none has
  BandRms data, model;
};
BandContent band_content(const SurfacePsd& surface, PsdTableKind kind, const FrequencyBand& band);
/// The same for every octave that the bins reach into: from 2^k to 2^(k+1) cycles/m, so that surfaces can be
/// compared octave by octave. `name` is empty.
std::vector<BandContent> octaves(const SurfacePsd& surface, PsdTableKind kind);

/// The form that drawings carry (ISO 10110-8): profile PSD A / f^B over a band.
struct DrawingLine {
  double exponent = 0, exponent_std = 0;        ///< B
  double amplitude = 0, log_amplitude_std = 0;  ///< A [m^(3-B)]; f in cycles/m
  double f_min = 0, f_max = 0;                  ///< [cycles/m]
  double confidence = 0;                        ///< of the interval of B
  double lower = 0, upper = 0;                  ///< of B
  double factor = 1;                            ///< RMS height of the line over that of the bins, in the band
  bool describes = true;                        ///< whether its misses are what chance allows
};
/// The power law that the bins of [f_min, f_max] are most likely to come from (fit_psd_model), response
/// included; of maps its profile. `exponent` NaN: no line (a surface whose profile PSD diverges; too few
/// bins).
DrawingLine drawing_line(const PsdEstimate& estimate, double f_min, double f_max);

/// The power law with the RMS height and slope of the bins in [f_min, f_max] (method of moments): not the
/// most likely one, but for a focus this very surface, whose few lowest bins no model of many has to follow.
/// Of maps its profile; no intervals. `exponent` NaN where no exponent has that ratio of slope to height.
DrawingLine line_as_measured(const SurfacePsd& surface, PsdTableKind kind, double f_min, double f_max);

}  // namespace aberfit
