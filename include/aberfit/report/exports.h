#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/measured/write_map.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

enum class ExportFormat {
  kZemaxGridSag,  ///< grid_sag.DAT
  kZernikeNoll,   ///< zernike_standard.txt: Zemax Zernike Standard listing
  kCodeVInt,      ///< surface.int
  kCodeVZfr,      ///< zernike_fringe.int
  kFitsOpd,       ///< opd.fits, for POPPY
  kCsv,           ///< surface.csv: x, y, h
};
/// "zemax-grid-sag", "zernike-noll", "codev-int", "codev-zfr", "fits-opd", "csv", in the order of the
/// enumeration.
const std::vector<std::string>& export_names();

/// A term surface to be carried into another program.
struct ExportInput {
  const TermSet& terms;
  const Eigen::VectorXd& coefficients;  ///< [m]
  const Aperture&
      aperture;       ///< points outside are no-data (grid sag: value kept, so that bicubic rims stay smooth)
  double wavelength;  ///< [m]
  int grid_size = 257;  ///< points per side, over the square around the aperture
  std::string title;
};

/// The surface and its analytic derivatives on a grid over the square around the aperture.
GridSag sample_surface(const ExportInput& input);

/// File name and content of one export. Throws std::invalid_argument for a format that cannot hold the
/// surface (a Zernike listing of Fourier terms).
std::pair<std::string, std::string> export_file(ExportFormat format, const ExportInput& input);

/// Zernike Standard coefficients of such a listing, by Noll index from 1 [waves], with the wavelength [m] and
/// normalisation radius [m] it states.
struct ZernikeListing {
  double wavelength = 0, radius = 0;
  std::vector<double> waves;
};
ZernikeListing read_zernike_listing(const std::string& path);
/// Fringe coefficients [m] from 1 of a CODE V ZFR file.
std::vector<double> read_codev_zfr(const std::string& path);

}  // namespace aberfit
