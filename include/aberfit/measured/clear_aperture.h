#pragma once
#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/measured/masking.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/scene/aperture.h"

namespace aberfit {

/// A size, either as a length or as a percentage of the extent of the data.
struct Extent {
  double value = 100;  ///< [m], or [%]
  bool percent = true;
};

/// Shapes that can be cut out of a measurement. Percentages refer to the diameter of the smallest circle
/// around all valid points (circle, annulus), to the sides of the smallest upright rectangle around them, or
/// to the length of the profile (interval).
struct ClearCircle {
  Extent diameter;
};
struct ClearAnnulus {
  Extent diameter, inner_diameter;
};
struct ClearRectangle {
  Extent width, height;
};
struct ClearInterval {
  Extent length;
};
struct ClearAperture {
  std::variant<ClearCircle, ClearAnnulus, ClearRectangle, ClearInterval> shape;
  /// Centre x, y (interval: x) relative to the middle of that circle, rectangle or profile [m]; empty: 0.
  std::vector<double> centre;
};

/// The part of a measurement that is used.
struct ClearPart {
  std::optional<ClearAperture> aperture;
  std::string mask;  ///< path of a mask of the same size; its zeros and NaN are left out; empty: no mask
  int erode = 0;  ///< number of samples removed at the rim of the valid region and at the rims of its holes

  bool whole() const { return !aperture && mask.empty() && erode == 0; }
};

/// The region that remains, for texts and pictures.
struct ClearRegion {
  /// The requested aperture, about (x, y) in the coordinates of the data [m]; an interval has height 0.
  std::optional<Aperture> aperture;
  double x = 0, y = 0;
  Eigen::Index taken_out = 0;  ///< number of valid samples that were removed
  /// Number of samples with a value that the study declares invalid; empty: it declares none.
  std::optional<Eigen::Index> said_invalid;

  /// Returns for example "circle of 48 mm about (0.1 mm, 0 m)"; empty without an aperture.
  std::string text() const;
  /// Returns the closed outlines of the aperture: 361 corners for a circle, two outlines for an annulus.
  std::vector<std::vector<std::array<double, 2>>> outlines() const;
};

/// Sets to NaN what is outside the aperture of `part`, then what its mask leaves out, then the rims. A sample
/// is at a rim if an invalid sample or the end of the data is within `erode` samples in its row, column or
/// diagonal.
/// mask_path: location of ClearPart::mask; mask_bottom_first: as for read_mask.
/// Throws std::invalid_argument with a sentence if the shape does not suit the data (an interval needs a
/// profile; other shapes and masks need a map), if a length exceeds twice the data, if the map has no pitch
/// or the mask another size, or if no sample remains. Throws InputError for a mask that cannot be read.
ClearRegion take_clear_part(Measurement* data, const ClearPart& part, const std::string& mask_path,
                            bool mask_bottom_first = false);

/// Returns the numbers of a mask, row 0 at the lowest y, from a FITS image or from text. The first line of a
/// text is the top row (bottom_first: the lowest). Blanks, commas or semicolons separate its numbers, and '#'
/// begins a comment. The units and scales of a FITS header do not matter. Throws InputError.
Grid read_mask(const std::string& path, bool bottom_first = false);

}  // namespace aberfit
