#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/measured/height_map.h"

// Measurements in a focal plane.
namespace aberfit {

/// Encircled energy about the centre of the spot.
struct EncircledCurve {
  Eigen::ArrayXd radius;  ///< ascending, > 0; [m] in the plane, or [rad] on the sky
  Eigen::ArrayXd share;   ///< fraction of the energy within the radius [1]
  Eigen::ArrayXd noise;   ///< standard deviation of each fraction [1]; empty if the file has none
  bool is_angle = false;  ///< true: the radii are angles on the sky
};

/// An image of the irradiance in a focal plane.
struct FocalImage {
  Grid light;             ///< irradiance in the unit of the file, linear; NaN: no value; row 0 is the lowest
  double pixel = 0;       ///< side of a square pixel [m] or [rad]; 0: the file does not state it
  bool is_angle = false;  ///< true: the pixels are angles on the sky
};

/// Reads columns of radius (or diameter), encircled energy and, optionally, its noise. The first row names
/// them with their units: "radius_um, share, noise" or "diameter [arcsec], ee [%]". An angle is on the sky.
/// '#' starts a comment.
/// unit: unit of the radii if the file has none, for example "um". Throws InputError with the line.
EncircledCurve read_encircled_curve(const std::string& path, const std::string& unit = "");

/// Reads a matrix of numbers (text; the first line is the top row) or the first image of a FITS file. A FITS
/// file has the pixel in PIXELSCL [arcsec], or in CDELT1 if CUNIT1 is a length or angle. Throws InputError.
FocalImage read_focal_image(const std::string& path);

/// Returns true if the file is an image: FITS, or text of more than three columns.
bool is_focal_image(const std::string& path);

}  // namespace aberfit
