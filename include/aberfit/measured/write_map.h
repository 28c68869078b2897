#pragma once
#include <string>

#include "aberfit/measured/height_map.h"

namespace aberfit {

// These functions return a map in a foreign format; the caller writes the file (report/result.h write_file).
// FORMATS lists the source of each format. All expect surface heights; NaN becomes the no-data mark. They
// throw std::invalid_argument for a map that the format cannot hold.

/// CODE V INT of type SUR: 16-bit integers scaled by max|h|, rounding error at most max|h| / 65,000.
std::string codev_int_text(const HeightMap& map, double wavelength, const std::string& title);

/// Bytes of a FITS image of the optical path difference [m], twice the surface height, for POPPY's
/// FITSOpticalElement. Values are doubles with BUNIT and PIXELSCL. The image is padded with zeros to the
/// square that POPPY requires; invalid points are 0.
std::string fits_opd_bytes(const HeightMap& map);

/// Heights with their analytic derivatives, all with the shape and orientation of map.height.
struct GridSag {
  HeightMap map;
  Grid dx, dy;  ///< dh/dx, dh/dy
  Grid dxdy;    ///< d2h/dxdy [1/m]
};
/// OpticStudio grid sag .DAT in millimetres: seven header numbers, then z, dz/dx, dz/dy, d2z/dxdy, nodata for
/// each point. The first point is (-x, +y).
std::string zemax_grid_sag_text(const GridSag& sag, const std::string& title);
/// Reads such a file with its derivatives.
GridSag read_zemax_grid_sag_with_derivatives(const std::string& path);

/// Columns x, y, h [m] of the valid points under a commented header.
std::string map_csv(const HeightMap& map);

}  // namespace aberfit
