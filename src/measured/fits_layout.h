#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "aberfit/measured/focal_data.h"
#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// Where the image of a FITS file is.
struct FitsImage {
  int hdu = 0;                         ///< from 1, as CFITSIO counts
  std::int64_t columns = 0, rows = 0;  ///< of the first slice
  int mask_hdu = 0;                    ///< a later image of that size with EXTNAME 'MASK'; 0: there is none
  std::uint64_t end = 0;               ///< bytes from the start of the file to the end of the data of both
};

/// The first header-data unit that is an image of two or more axes with data in it, and the mask that may
/// follow it. Checks every header against the length of the file, so that what is handed to CFITSIO
/// afterwards cannot make it allocate or read beyond. Throws InputError naming the header key. Source: FITS
/// standard 4.0 (IAU 2016), sections 3.3, 4.1, 4.4.1, 6.1 (size of the data), 7.1.
FitsImage find_fits_image(const std::string& path, std::string_view bytes);

/// The numbers of that image, row 0 the lowest, whatever they mean; NaN where they are blank, not finite or
/// left out by the mask behind it. Throws InputError.
Grid fits_pixels(const std::string& path);

/// The same as light in a focal plane.
FocalImage read_fits_image(const std::string& path);

}  // namespace aberfit::internal
