#pragma once
#include <string>

#include "aberfit/measured/height_map.h"

namespace aberfit {

// Text or bytes of a map in a foreign format; the caller writes them (report/result.h write_file). FORMATS
// says where each was learnt. All take the surface; NaN becomes the format's no-data mark. Throw
// std::invalid_argument for a map the format cannot hold.

/// CODE V INT of kind SUR: integers of 16 bits scaled by the largest |height|, so the rounding is at most
/// max|h| / 65,000.
std::string codev_int_text(const HeightMap& map, double wavelength, const std::string& title);

/// FITS image of the optical path difference [m] (twice the surface) that POPPY's FITSOpticalElement loads:
/// double, BUNIT, PIXELSCL, padded to a square with zeros (POPPY wants one); invalid points are 0 in the OPD.
/// Returns the bytes of the file.
std::string fits_opd_bytes(const HeightMap& map);

/// Heights with their analytic derivatives on one grid, for formats that carry them. Same shape and
/// orientation as map.height.
struct GridSag {
  HeightMap map;
  Grid dx, dy;  ///< dh/dx, dh/dy
  Grid dxdy;    ///< d2h/dxdy [1/m]
};
/// OpticStudio grid sag .DAT in millimetres: seven header numbers, then z, dz/dx, dz/dy, d2z/dxdy, nodata;
/// first line is (-x, +y).
std::string zemax_grid_sag_text(const GridSag& sag, const std::string& title);
/// The same file read with its derivatives.
GridSag read_zemax_grid_sag_with_derivatives(const std::string& path);

/// Columns x, y, h [m] of the valid points, with a commented header.
std::string map_csv(const HeightMap& map);

}  // namespace aberfit
