#pragma once
#include <string>
#include <vector>

#include "aberfit/focus/evaluate.h"
#include "aberfit/report/result.h"
#include "aberfit/scatter/geometric_harvey_shack.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// What the pictures show. Bundles share one pupil.
struct PlotInput {
  const ResultDocument& result;
  const Mirror& mirror;
  const PupilSample& pupil;
  const RayBundle& ideal;
  const RayBundle&
      target;  ///< Harvey-Shack branch by ray perturbation; empty (size 0) when there is no roughness
  const RayBundle& fitted;
  const SurfaceField& fitted_field;     ///< at the pupil points
  const SurfaceOperator& surface_grid;  ///< L on a square grid of the aperture, row by row from -y to +y
  int grid_size;                        ///< points per side
  double focal_sigma;                   ///< [m]
};

/// Writes data files, gnuplot scripts and - when gnuplot is there - PNG pictures below `directory`/plots.
/// Returns the PNG paths; a missing or failing gnuplot is a warning (code `no-gnuplot`), the data and scripts
/// stay usable.
std::vector<std::string> write_plots(const PlotInput& input, const std::string& directory,
                                     Warnings* warnings);

}  // namespace aberfit
