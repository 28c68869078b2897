// Stands for the files that need HDF5 where the library is built with ABERFIT_HDF5 off.
#include "aberfit/measured/read_measurement.h"
#include "is_4d_hdf5.h"

namespace aberfit {
namespace {

[[noreturn]] void refuse_hdf5(const std::string& path) {
  throw InputError(path, "", "an HDF5 file", "another format, or an aberfit built with HDF5 (ABERFIT_HDF5)");
}

}  // namespace

bool internal::is_4d_hdf5(const std::string&) { return false; }
HeightMap read_datx(const MeasuredSource& source) { refuse_hdf5(source.path); }
HeightMap read_4d(const MeasuredSource& source) { refuse_hdf5(source.path); }

}  // namespace aberfit
