#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// Contents of the pictures of a fit.
struct FitPictures {
  const ResultDocument& result;
  const Mirror& mirror;
  const Aperture& aperture;  ///< the part of the surface grid on the mirror
  double wavelength;         ///< [m]; mean of a band
  const RadialPsd* psd;      ///< specification; null without roughness
  const PupilSample& pupil;
  const FocalLight& ideal;
  const FocalLight* target;  ///< by the theory of the targets; null without roughness
  const FocalLight& fitted;
  const SurfaceField& fitted_field;  ///< at the pupil points
  /// L on a square grid of grid_size x grid_size points, row by row from -y to +y, each row from -x to +x.
  /// The outermost points lie on x, y = +-aperture_radius(aperture). Points outside the aperture are not
  /// shown.
  const SurfaceOperator& surface_grid;
  int grid_size;  ///< points per side, at least 2
  /// Scale [m] of the focal spot, or of its core if it has core and halo; 0 if there is none.
  double core_sigma;
};

/// Writes data files and gnuplot scripts below `directory`/plots and draws them if gnuplot is installed. The
/// pictures have the order of a report: map_heights and map_light (of a fitted map); specified_psd;
/// ee_curves, ring_through, focal_images, focal_core and mtf (the last two by wave optics); bsdf; surface,
/// profile, gradients and coefficients (with terms); character; frontier (of a search for terms). The terms
/// of a map without roughness whose statistics need wave optics have no pictures of the focus, because a spot
/// of rays would be wrong.
///
/// Data files are text in SI units with a commented header. A script NAME.gp reads them, common.gp and
/// NAME.values by names without a folder, so `gnuplot NAME.gp` in that folder draws it again. Pictures of an
/// earlier run with these names are removed. A missing or failing gnuplot is a warning (code `no-gnuplot`);
/// data and scripts stay usable. Throws InputError if a file cannot be written.
std::vector<DrawnPicture> draw_pictures(const FitPictures& fit, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

/// Names of those pictures.
const std::vector<std::string>& fit_picture_names();

}  // namespace aberfit
