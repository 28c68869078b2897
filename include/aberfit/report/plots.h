#pragma once
#include <string>
#include <vector>

#include "aberfit/report/focal_light.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// What the pictures show.
struct PlotInput {
  const ResultDocument& result;
  const Mirror& mirror;
  const Aperture& aperture;  ///< what of the surface grid is mirror
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

/// Writes data files, gnuplot scripts and - when gnuplot is there - PNG pictures below `directory`/plots, and
/// returns the paths of the PNGs: ee_curves, ring_through, focal_images, surface, profile, coefficients,
/// gradients, frontier, character, map_heights, map_light. The first three are left out for the terms of a
/// map without roughness whose statistics are those of waves (rays would draw a spot that light does not
/// make), the next three need coefficients, frontier a search for terms, character a fit of a specification's
/// roughness, the last two a fitted map. Files of these pictures that an earlier run left there and this one
/// does not draw are removed. Data files are text in SI units with a commented header; scripts name them
/// without folder, so `gnuplot ee_curves.gp` in that folder draws again. A missing or failing gnuplot is a
/// warning (code `no-gnuplot`); data and scripts stay usable. Throws InputError when a file cannot be
/// written.
std::vector<std::string> write_plots(const PlotInput& input, const std::string& directory,
                                     Warnings* warnings);

}  // namespace aberfit
