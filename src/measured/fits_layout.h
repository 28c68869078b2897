#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/measured/focal_data.h"
#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// An image of two or more axes in a FITS file.
struct FitsImage {
  int hdu = 0;       ///< from 0, the primary, as astropy and the names of CFITSIO count
  std::string name;  ///< EXTNAME; may be empty
  std::string unit;  ///< BUNIT, else Z_UNIT of PROPER; may be empty
  std::int64_t columns = 0, rows = 0;
  std::int64_t planes = 1;  ///< of a cube, all axes beyond the second together
  std::uint64_t end = 0;    ///< bytes from the start of the file to the end of its data

  bool is_mask() const { return name == "MASK"; }
};

/// All header-data units that are images of two or more axes with data in them, at least one. Checks every
/// header against the length of the file, so that what is handed to CFITSIO afterwards cannot make it
/// allocate or read beyond. Throws InputError naming the header key. Source: FITS standard 4.0 (IAU 2016),
/// sections 3.3, 4.1, 4.4.1, 6.1 (size of the data), 7.1.
std::vector<FitsImage> find_fits_images(const std::string& path, std::string_view bytes);

/// The mask of an image: another of that size with EXTNAME 'MASK'; nullptr where there is none.
const FitsImage* mask_of(const FitsImage& image, const std::vector<FitsImage>& images);

/// "0 (72 x 72, no unit), 1 'OPD' (72 x 72, nm)", for messages.
std::string fits_image_list(const std::vector<FitsImage>& images);

/// The numbers of the first image that is no mask of another, its first plane, row 0 the lowest, whatever
/// they mean; NaN where they are blank, not finite or left out by its mask. Throws InputError.
Grid fits_pixels(const std::string& path);

/// The same as light in a focal plane.
FocalImage read_fits_image(const std::string& path);

}  // namespace aberfit::internal
