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

/// A term surface for another program. It has the terms alone; the other program adds them to its own surface
/// of the nominal mirror (conic, even powers and known Zernikes).
struct ExportInput {
  const TermSet& terms;
  const Eigen::VectorXd& coefficients;  ///< [m]
  const Aperture&
      aperture;       ///< points outside have no data; a grid sag keeps values near the rim (sample_surface)
  double wavelength;  ///< [m]
  int grid_size = 257;  ///< points per side, over the square around the aperture
  std::string title;
};

/// The surface and its analytic derivatives on a grid over the square around the aperture. The square is the
/// bounding box made square, with the rim on the outermost rows and columns; only that of a polygon may be
/// off the axis. Two cells beyond the rim keep the values of the terms, so every cell of an aperture wider
/// than two pitches has four corners. All four grids are NaN farther out, and where the height exceeds 1000
/// times the largest inside. Bicubic interpolation at 257 points, n <= 20, has an RMS error below 1e-4 of the
/// RMS height, and EE90 within 0.1 %; bilinear interpolation has slopes 16 % off. Throws
/// std::invalid_argument for a wavelength that is not positive, fewer than 5 points, or coefficients that are
/// not finite or not one per term.
GridSag sample_surface(const ExportInput& input);

/// The file of an export: "grid_sag.DAT", ...
const std::string& export_file_name(ExportFormat format);
/// File name and content of one export. Throws std::invalid_argument for a format that cannot hold the
/// surface (a Zernike listing of Fourier terms, or of more than the 231 Zernike Standard terms of n <= 20).
/// Spherical terms go into the listings exactly, as Zernikes of m = 0. The margin of the aperture is not
/// taken off.
std::pair<std::string, std::string> export_file(ExportFormat format, const ExportInput& input);

/// Peak-normalised Fringe coefficients [m] of the surface, from index 1, of a CODE V ZFR file; those of a WFR
/// file are halved. InputError names file, line, what was found and what is allowed.
std::vector<double> read_codev_zfr(const std::string& path);

}  // namespace aberfit
