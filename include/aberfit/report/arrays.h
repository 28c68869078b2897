#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/output_formats.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/theory/halo_kernel.h"

namespace aberfit {

/// The focus to be written, by theory, of the surface, or both.
struct ArrayInput {
  const FocalLight* theory;   ///< null: none
  const FocalLight* surface;  ///< null: none; at least one of the two is given
  const Mirror& mirror;
  const Aperture& aperture;
  double wavelength;           ///< [m]
  std::vector<double> planes;  ///< dz [m] of the encircled energies; z = f is always added
  double core_sigma;           ///< scale of the focal spot [m]; 0: taken from the spot itself
  std::string title;
  const RadialPsd* rest = nullptr;  ///< the roughness that scatters beside the terms; null: none
};

/// The focus by theory or of the surface, on the axes of FocusArrays. Unknown parts are empty.
struct LightArrays {
  Eigen::ArrayXXd encircled_energy;  ///< fraction of the energy, planes x radii
  /// Mean irradiance between neighbouring radii, as fraction of the energy per area [1/m^2], planes x rings.
  Eigen::ArrayXXd ring_profile;
  Eigen::ArrayXXd psf;                ///< mean irradiance of a pixel at z = f [1/m^2], column = x, row = y
  std::optional<TransferImage> otf;   ///< OTF of one surface by wave optics
  std::optional<Eigen::ArrayXd> mtf;  ///< real part of the OTF of theory at `frequency`
};

/// The numbers behind the pictures of the focus. The sum of the PSF times the area of a pixel is the fraction
/// of the energy inside the window. Pixels are at most half of lambda f/D wide, if 513 of them suffice.
struct FocusArrays {
  std::string title;
  double wavelength = 0, focal_length = 0, diameter = 0;  ///< [m]
  Eigen::ArrayXd plane;                                   ///< dz [m], ascending
  Eigen::ArrayXd radius;                                  ///< [m], from 0
  Eigen::ArrayXd pixel;                                   ///< centres along x and y [m]
  Eigen::ArrayXd frequency;                               ///< from 0 [cycles/m]; empty: no OTF
  std::optional<LightArrays> theory, surface;
  /// Scatter of the roughness beside the terms on the pixels of the PSF. `surface` has it already.
  std::optional<HaloKernel> halo;
};
FocusArrays make_focus_arrays(const ArrayInput& input);

/// Names and contents of the files of a format (FORMATS.md). kNone has none; FITS omits otf.fits if there is
/// no OTF.
std::vector<std::pair<std::string, std::string>> array_files(ArrayFormat format, const FocusArrays& arrays);

}  // namespace aberfit
