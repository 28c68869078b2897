#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// What the pictures of a fit show.
struct FitPictures {
  const ResultDocument& result;
  const Mirror& mirror;
  const Aperture& aperture;  ///< what of the surface grid is mirror
  double wavelength;         ///< [m]; of a band its mean
  const RadialPsd* psd;      ///< of the specification; null without roughness
  const PupilSample& pupil;
  const FocalLight& ideal;
  const FocalLight* target;  ///< of the theory that the targets come from; null without roughness
  const FocalLight& fitted;
  const SurfaceField& fitted_field;  ///< at the pupil points
  /// L on a square grid of grid_size x grid_size points, row by row from -y to +y, each row from -x to +x;
  /// the outermost points lie on x, y = +-aperture_radius(aperture). Points outside the aperture are not
  /// shown, whatever L gives there.
  const SurfaceOperator& surface_grid;
  int grid_size;  ///< points per side, at least 2
  /// Scale of the focal spot, or of its core where it has core and halo [m]; 0 where there is none.
  double core_sigma;
};

/// Writes data files and gnuplot scripts below `directory`/plots and draws them where gnuplot is there. The
/// pictures come in the order of a report: map_heights and map_light (of a fitted map); specified_psd;
/// ee_curves, ring_through, focal_images, focal_core and mtf (the last two by waves); bsdf; surface, profile,
/// gradients and coefficients (with terms); character; frontier (a search for terms). Those of the focus are
/// left out for the terms of a map without roughness whose statistics are those of waves: rays would draw a
/// spot that light does not make.
///
/// Data files are text in SI units with a commented header. A script NAME.gp reads them, common.gp and
/// NAME.values by names without a folder, so that `gnuplot NAME.gp` there draws it again. Pictures of an
/// earlier run with these names are removed. A missing or failing gnuplot is a warning (code `no-gnuplot`);
/// data and scripts stay usable. Throws InputError when a file cannot be written.
std::vector<DrawnPicture> draw_pictures(const FitPictures& fit, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

/// Names of those pictures.
const std::vector<std::string>& fit_picture_names();

}  // namespace aberfit
