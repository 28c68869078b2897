#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/measured/height_map.h"

namespace aberfit {

/// A card of a FITS header. key: at most 8 characters.
struct FitsCard {
  std::string key;
  std::variant<double, std::int64_t, std::string> value;
  std::string comment;
};

/// An image of a FITS file with the cards behind those that say its shape.
struct FitsImageUnit {
  std::string name;  ///< EXTNAME; empty: none
  Grid values;       ///< row 0 is the lowest, as FITS has it; one row: an image of one axis
  std::vector<FitsCard> cards;
};

/// The bytes of a FITS file of images in double precision (BITPIX -64), the first of them its primary one.
/// NaN is NaN. Throws std::runtime_error where CFITSIO cannot write it.
std::string fits_bytes(const std::vector<FitsImageUnit>& images);

}  // namespace aberfit
