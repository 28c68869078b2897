#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/output_formats.h"
#include "aberfit/measured/write_map.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// A term surface to be carried into another program: the terms alone, to be added to the nominal mirror
/// (conic, even powers and known Zernikes), which the other program is to have as a surface of its own.
struct ExportInput {
  const TermSet& terms;
  const Eigen::VectorXd& coefficients;  ///< [m]
  const Aperture&
      aperture;       ///< points outside are no-data (grid sag: value kept, so that bicubic rims stay smooth)
  double wavelength;  ///< [m]
  int grid_size = 257;  ///< points per side, over the square around the aperture
  std::string title;
};

/// The surface and its analytic derivatives on a grid over the square around the aperture (its bounding box
/// made square, rim on the outermost rows and columns; middle off the axis only for a polygon). Two cells
/// beyond the rim keep the values of the terms, so that every cell of an aperture wider than two pitches has
/// four corners; everything farther out is NaN in all four grids, as is what has grown to 1000 times the
/// largest height inside. Read with bicubic interpolation at 257 points, n <= 20: RMS error below 1e-4 of the
/// RMS height, EE90 within 0.1 %; read bilinearly the slopes are 16 % off. Throws std::invalid_argument for a
/// wavelength that is not positive, fewer than 5 points, or coefficients that are not finite or not one per
/// term.
GridSag sample_surface(const ExportInput& input);

/// The file of an export: "grid_sag.DAT", ...
const std::string& export_file_name(ExportFormat format);
/// File name and content of one export. Throws std::invalid_argument for a format that cannot hold the
/// surface (a Zernike listing of Fourier terms, or of more than the 231 Zernike Standard terms of n <= 20).
/// Spherical terms go into the listings exactly, as Zernikes of m = 0. The margin of the aperture is not
/// taken off.
std::pair<std::string, std::string> export_file(ExportFormat format, const ExportInput& input);

/// Fringe coefficients [m] of the surface, from 1, peak-normalised, of a CODE V ZFR file; those of a WFR file
/// are halved. InputError names file, line, what was found and what is allowed.
std::vector<double> read_codev_zfr(const std::string& path);

}  // namespace aberfit
