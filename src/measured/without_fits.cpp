// Stands for the files that need CFITSIO where the library is built with ABERFIT_FITS off.
#include <stdexcept>

#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_fits.h"
#include "aberfit/measured/write_map.h"
#include "fits_layout.h"

namespace aberfit {
namespace {

[[noreturn]] void refuse_fits(const std::string& path) {
  throw InputError(path, "", "a FITS file",
                   "another format, or an aberfit built with CFITSIO (ABERFIT_FITS)");
}

}  // namespace

Grid internal::fits_pixels(const std::string& path) { refuse_fits(path); }
FocalImage internal::read_fits_image(const std::string& path) { refuse_fits(path); }
HeightMap read_fits(const MeasuredSource& source) { refuse_fits(source.path); }

std::string fits_bytes(const std::vector<FitsImageUnit>&) {
  throw std::invalid_argument("FITS needs an aberfit that was built with CFITSIO (ABERFIT_FITS)");
}
std::string fits_opd_bytes(const HeightMap&) { return fits_bytes({}); }

}  // namespace aberfit
