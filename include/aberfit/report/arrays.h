#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/output_formats.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/scene/aperture.h"

namespace aberfit {

/// Whose light is to be written.
struct ArrayInput {
  const FocalLight* theory;   ///< null: none
  const FocalLight* surface;  ///< null: none; one of the two is there
  const Mirror& mirror;
  const Aperture& aperture;
  double wavelength;           ///< [m]
  std::vector<double> planes;  ///< dz [m] of the encircled energies; z = f is always among them
  double core_sigma;           ///< scale of the focal spot [m]; 0: as the light has it
  std::string title;
};

/// One light on the axes of FocusArrays; empty, or nothing, where it is not known.
struct LightArrays {
  Eigen::ArrayXXd encircled_energy;  ///< share of the light, planes x radii
  /// Mean irradiance between neighbouring radii, share of the light per area [1/m^2], planes x rings.
  Eigen::ArrayXXd ring_profile;
  Eigen::ArrayXXd psf;                ///< mean irradiance of a pixel at z = f [1/m^2], column = x, row = y
  std::optional<TransferImage> otf;   ///< of one surface by waves
  std::optional<Eigen::ArrayXd> mtf;  ///< of theory: the real part of its OTF, at `frequency`
};

/// What the pictures of the focus show, in numbers. Sum of the PSF times the area of a pixel is the light
/// inside the window; pixels are at most half of lambda f/D wide as far as 513 of them reach.
struct FocusArrays {
  std::string title;
  double wavelength = 0, focal_length = 0, diameter = 0;  ///< [m]
  Eigen::ArrayXd plane;                                   ///< dz [m], ascending
  Eigen::ArrayXd radius;                                  ///< [m], from 0
  Eigen::ArrayXd pixel;                                   ///< centres along x and y [m]
  Eigen::ArrayXd frequency;                               ///< from 0 [cycles/m]; empty: no OTF
  std::optional<LightArrays> theory, surface;
};
FocusArrays make_focus_arrays(const ArrayInput& input);

/// Names and contents of the files of a format, FORMATS.md: none for kNone; FITS leaves otf.fits out where
/// there is no OTF.
std::vector<std::pair<std::string, std::string>> array_files(ArrayFormat format, const FocusArrays& arrays);

}  // namespace aberfit
