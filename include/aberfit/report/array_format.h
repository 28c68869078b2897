#pragma once
#include <string>
#include <vector>

namespace aberfit {

/// What the arrays behind the pictures are written as (report/arrays.h).
enum class ArrayFormat {
  kNone,
  kNpz,   ///< arrays.npz, for numpy.load
  kCsv,   ///< one table each
  kFits,  ///< psf.fits and otf.fits; curves are not written
};
/// "none", "npz", "csv", "fits", in the order of the enumeration.
const std::vector<std::string>& array_format_names();

}  // namespace aberfit
