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

/// A map with its RMS about the mean and its peak to valley [m], of all its valid points.
struct MapPanel {
  HeightMap map;
  double rms = 0, peak_to_valley = 0;
  double rms_slope_x = 0, rms_slope_y = 0;  ///< as PsdEstimate::rms_slope_x, of these heights as they are
};

/// A fitted map beside its terms, at the points that have a value inside the aperture; NaN elsewhere. Piston
/// and tilt of the mount (MapFitResult::mount) are off the measured heights, so that measured = fitted +
/// residual.
struct MapPanels {
  MapPanel measured, fitted, residual;
};

/// The light of one surface in the focus z = f, about the nominal focus. NaN: no such value.
struct LitSurface {
  std::string obstacle;  ///< why it has no light, a clause; empty: it has
  /// Highest irradiance over that of the same pupil without any height, as StrehlRatio of a surface.
  double strehl = kNaN;
  double ee50 = kNaN, ee80 = kNaN, ee90 = kNaN;  ///< radii [m]
  double spot_fwhm = kNaN;                       ///< of the line spread, mean of x and y [m]
  Eigen::ArrayXd share;                          ///< of the light inside MapLight::radius
  /// Irradiance over the highest of the pupil without heights; empty where cells are not square.
  PsfImage psf;
};

/// PSD of what the terms leave of a map.
struct ResidualPsd {
  std::string obstacle;         ///< why there is none, a clause; empty: there is
  double f_min = 0, f_max = 0;  ///< [cycles/m]
  double rms_height = 0;        ///< inside them [m]
  double tis = 0;               ///< share of the light that it scatters
};

/// The light of a fitted map, by waves on the map's own points: of the heights as measured, of the terms
/// alone, of the terms with the mean scatter of the residual's PSD, and of the mirror without any of them.
struct MapLight {
  /// All of the aperture lets light through: a hole in the data is none in the mirror. Points without a value
  /// have the height of the terms, in all columns alike.
  double filled_share = 0;  ///< of the aperture's area
  Eigen::Index cells = 0;   ///< of the pupil
  LitSurface measured, terms, terms_and_rest, perfect;
  ResidualPsd rest;
  Eigen::ArrayXd radius;    ///< of the curves [m]
  double ring_fwhm = kNaN;  ///< of the terms, see RingFwhm [m]; NaN unless asked for
  Warnings warnings;

  std::array<const LitSurface*, 4> columns() const { return {&measured, &terms, &terms_and_rest, &perfect}; }
};

/// The heights of the three panels. map: about the axis of the aperture, NaN outside it; fit: of `terms` to
/// it.
MapPanels map_panels(const HeightMap& map, const Aperture& aperture, const TermSet& terms,
                     const MapFitResult& fit, int threads);

/// The light of these panels on the mirror of the task: a surface height h is a path of 2h, positive towards
/// the light. The pupil is paraxial (diffraction_pupil of a map): radii err by 1/(32 N^2), N the f-number,
/// alike in all columns. The PSD of the residual is that of estimate_psd (Hann's window, piston off, lines
/// left in), its response divided out (surface_psd), level in each bin, from where the terms end to its first
/// bin, and beyond its last to 2/sqrt(pi) of the map's Nyquist frequency: a disc with the area of the grid's
/// square of frequencies. Its transfer function is paraxial generalised Harvey-Shack's. with_ring:
/// `ring_fwhm`, too. Trouble is an obstacle of the column it touches, or a warning: `map-filled` where more
/// than 5 % of the aperture has no height, `residual-psd-rms` where the RMS of the PSD is not that of the
/// residual and light can tell.
MapLight map_light(const Task& task, const MapPanels& panels, const TermSet& terms, const MapFitResult& fit,
                   bool with_ring, int threads);

}  // namespace aberfit
