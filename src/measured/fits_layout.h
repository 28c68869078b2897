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
  int hdu = 0;       ///< number from 0, the primary unit, as in astropy and the file names of CFITSIO
  std::string name;  ///< EXTNAME; may be empty
  std::string unit;  ///< BUNIT, otherwise PROPER's Z_UNIT; may be empty
  std::int64_t columns = 0, rows = 0;
  std::int64_t planes = 1;  ///< number of planes: product of all axes beyond the second
  std::uint64_t end = 0;    ///< bytes from the start of the file to the end of its data

  bool is_mask() const { return name == "MASK"; }
};

/// Returns all units that are images of two or more axes with data; at least one. Checks every header against
/// the length of the file, so that CFITSIO cannot allocate or read beyond it. Throws InputError with the
/// header key. Source: FITS standard 4.0 (IAU 2016), sections 3.3, 4.1, 4.4.1, 6.1 (size of the data), 7.1.
std::vector<FitsImage> find_fits_images(const std::string& path, std::string_view bytes);

/// Returns the mask of an image, one of the same size with EXTNAME 'MASK'; nullptr if there is none.
const FitsImage* mask_of(const FitsImage& image, const std::vector<FitsImage>& images);

/// Returns for example "0 (72 x 72, no unit), 1 'OPD' (72 x 72, nm)", for messages.
std::string fits_image_list(const std::vector<FitsImage>& images);

/// Returns the first plane of the first image that is not a mask, row 0 the lowest, in the unit of the file.
/// Values are NaN where they are blank, not finite or masked. Throws InputError.
Grid fits_pixels(const std::string& path);

/// Reads the same image as an irradiance in a focal plane, with its pixel size.
FocalImage read_fits_image(const std::string& path);

}  // namespace aberfit::internal
