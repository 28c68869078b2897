#pragma once
#include <Eigen/Core>
#include <array>
#include <string>

#include "aberfit/core/constants.h"
#include "aberfit/core/warning.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/method/task.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// A map with its RMS about the mean and its peak to valley [m] over all valid points.
struct MapPanel {
  HeightMap map;
  double rms = 0, peak_to_valley = 0;
  double rms_slope_x = 0, rms_slope_y = 0;  ///< from the unprocessed heights, as PsdEstimate::rms_slope_x
};

/// A fitted map beside its terms, at the valid points inside the aperture; NaN elsewhere. Piston and tilt of
/// the mount (MapFitResult::mount) are removed, so that measured = fitted + residual.
struct MapPanels {
  MapPanel measured, fitted, residual;
};

/// Statistics of one surface in the focus z = f, about the nominal focus, by wave optics. NaN: no value.
struct LitSurface {
  std::string obstacle;  ///< why it could not be computed, a clause; empty: it was
  /// Peak irradiance over that of the same pupil with zero height, as in StrehlRatio.
  double strehl = kNaN;
  double ee50 = kNaN, ee80 = kNaN, ee90 = kNaN;  ///< radii [m]
  double spot_fwhm = kNaN;                       ///< FWHM of the line spread, mean of x and y [m]
  Eigen::ArrayXd share;                          ///< energy fraction inside each MapLight::radius
  /// Irradiance over the peak of the pupil with zero height; empty where grid cells are not square.
  PsfImage psf;
};

/// PSD of the residual that the terms leave of a map.
struct ResidualPsd {
  std::string obstacle;         ///< why there is none, a clause; empty: there is one
  double f_min = 0, f_max = 0;  ///< band [cycles/m]
  double rms_height = 0;        ///< within that band [m]
  double tis = 0;               ///< fraction of the energy that it scatters
};

/// Statistics of a fitted map by wave optics on the map's points, for four surfaces: the measured heights,
/// the terms, the terms with the mean scatter of the residual's PSD, and the perfect mirror.
struct MapLight {
  /// The whole aperture reflects, because a hole in the data is no hole in the mirror. Points without a value
  /// have the height of the terms on all surfaces.
  double filled_share = 0;  ///< fraction of the aperture's area
  Eigen::Index cells = 0;   ///< grid cells of the pupil
  LitSurface measured, terms, terms_and_rest, perfect;
  ResidualPsd rest;
  Eigen::ArrayXd radius;    ///< abscissae of the encircled-energy curves [m]
  double ring_fwhm = kNaN;  ///< FWHM of the terms [m], see RingFwhm; NaN unless requested
  Warnings warnings;

  std::array<const LitSurface*, 4> columns() const { return {&measured, &terms, &terms_and_rest, &perfect}; }
};

/// Heights of the three panels. map: about the axis of the aperture, NaN outside it; fit: of `terms` to it.
MapPanels map_panels(const HeightMap& map, const Aperture& aperture, const TermSet& terms,
                     const MapFitResult& fit, int threads);

/// Statistics of these panels on the mirror of the task. A surface height h is a path of 2h, positive towards
/// the source. The pupil is paraxial (diffraction_pupil of a map): radii err by 1/(32 N^2), N the f-number,
/// alike for all surfaces. The PSD of the residual comes from estimate_psd (Hann's window, piston removed,
/// lines kept) with its response divided out (surface_psd). It is constant in each bin and extrapolated as a
/// constant from the end of the terms to the first bin. Beyond the last bin it continues to 2/sqrt(pi) of the
/// map's Nyquist frequency: a disc with the area of the grid's square of frequencies. Its transfer function
/// is that of paraxial generalised Harvey-Shack. with_ring: also computes `ring_fwhm`. A failure is the
/// obstacle of its surface, or a warning: `map-filled` where more than 5 % of the aperture has no height;
/// `residual-psd-rms` where the RMS of the PSD differs from that of the residual and the spot depends on it.
MapLight map_light(const Task& task, const MapPanels& panels, const TermSet& terms, const MapFitResult& fit,
                   bool with_ring, int threads);

}  // namespace aberfit
