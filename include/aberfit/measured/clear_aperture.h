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

/// A size: a length, or a share of the data's own extent.
struct Extent {
  double value = 100;  ///< [m], or [%]
  bool percent = true;
};

/// Shapes that may be cut out of a measurement. Percentages: of the diameter of the smallest circle that
/// holds every valid point (circle, annulus), of the sides of the smallest upright rectangle that does, of
/// the length of a profile.
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
  /// x, y (interval: x) from the middle of that circle, rectangle or record [m]; empty: there.
  std::vector<double> centre;
};

/// What of a measurement is used.
struct ClearPart {
  std::optional<ClearAperture> aperture;
  std::string mask;  ///< a map of the same size whose zeros and NaN are left out; empty: none
  int erode = 0;     ///< samples taken off the rim of what is valid, and off the rims of its holes

  bool whole() const { return !aperture && mask.empty() && erode == 0; }
};

/// What came of it, for texts and pictures.
struct ClearRegion {
  /// Where one was asked for, about (x, y) in the coordinates of the data [m]; an interval is a rectangle of
  /// height 0.
  std::optional<Aperture> aperture;
  double x = 0, y = 0;
  Eigen::Index taken_out = 0;  ///< samples that were valid
  /// Samples that are holes since their value is one of those that were said to be invalid; where none was
  /// said, empty.
  std::optional<Eigen::Index> said_invalid;

  /// "circle of 48 mm about (0.1 mm, 0 m)"; empty without an aperture.
  std::string text() const;
  /// Corners of its outlines, closed; of a circle 361, of an annulus two outlines.
  std::vector<std::vector<std::array<double, 2>>> outlines() const;
};

/// Takes out (NaN) what does not belong to `part`: outside the aperture, then of the mask, then at the rims.
/// A sample is at the rim where, within `erode` along rows, columns and diagonals, one is invalid or the data
/// end. Throws std::invalid_argument with a sentence: a shape that the data cannot have (interval: profiles
/// only, others and masks: maps only), a length of more than twice the data's own, an aperture on a map
/// without pitch, a mask of another size, nothing left. InputError for a mask that cannot be read. mask_path:
/// where ClearPart::mask is; mask_bottom_first: as for read_mask.
ClearRegion take_clear_part(Measurement* data, const ClearPart& part, const std::string& mask_path,
                            bool mask_bottom_first = false);

/// Numbers of a mask, row 0 at the lowest y: the pixels of a FITS image, whatever its header says of them,
/// or text, first line the top row (the lowest for bottom_first), blanks, commas or semicolons between, '#'
/// begins a comment. Throws InputError.
Grid read_mask(const std::string& path, bool bottom_first = false);

}  // namespace aberfit
