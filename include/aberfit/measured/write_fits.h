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

/// An image of a FITS file and its cards, without the cards that define its shape.
struct FitsImageUnit {
  std::string name;  ///< EXTNAME; empty: no name
  Grid values;       ///< row 0 is the lowest, as in FITS; a single row makes an image of one axis
  std::vector<FitsCard> cards;
};

/// Returns the bytes of a FITS file with images in double precision (BITPIX -64). The first image is the
/// primary one. NaN stays NaN. Throws std::runtime_error if CFITSIO cannot write it.
std::string fits_bytes(const std::vector<FitsImageUnit>& images);

}  // namespace aberfit
