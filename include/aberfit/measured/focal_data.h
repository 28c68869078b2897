#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/measured/height_map.h"

// What is measured in a focal plane.
namespace aberfit {

/// Share of the light within circles about its centre.
struct EncircledCurve {
  Eigen::ArrayXd radius;  ///< ascending, > 0; [m] in the plane, or [rad] on the sky
  Eigen::ArrayXd share;   ///< [1]
  Eigen::ArrayXd noise;   ///< standard deviation of each share [1]; empty where the file does not say
  bool is_angle = false;  ///< radii are on the sky
};

/// An image of the light.
struct FocalImage {
  Grid light;             ///< in the file's units, linear; NaN where there is no value; row 0 the lowest
  double pixel = 0;       ///< side of a pixel, square [m] or [rad]; 0: the file does not say
  bool is_angle = false;  ///< pixels are on the sky
};

/// Columns radius (or diameter), share and, if wanted, noise: the first row names them with their units,
/// "radius_um, share, noise" or "diameter [arcsec], ee [%]"; an angle is on the sky. '#' starts a comment.
/// unit: of radii without one in the file, "um". Throws InputError with the line.
EncircledCurve read_encircled_curve(const std::string& path, const std::string& unit = "");

/// A matrix of numbers (text, first line = top row), or the first image of a FITS file, its pixel from
/// PIXELSCL [arcsec], or from CDELT1 where CUNIT1 is a length or an angle. Throws InputError.
FocalImage read_focal_image(const std::string& path);

/// Whether a file is an image: FITS, or text of more than three columns.
bool is_focal_image(const std::string& path);

}  // namespace aberfit
