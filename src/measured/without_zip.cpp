// Stands for the files that need libzip and pugixml where the library is built with ABERFIT_ZIP off.
#include "aberfit/measured/read_measurement.h"
#include "gzip.h"

namespace aberfit {
namespace {

[[noreturn]] void refuse_packed(const std::string& path, const char* what) {
  throw InputError(path, "", what,
                   "an unpacked file of another format, or an aberfit built with libzip (ABERFIT_ZIP)");
}

}  // namespace

bool internal::is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }
std::string internal::unpacked_gzip(const std::string& path, std::string_view) {
  refuse_packed(path, "a gzip file");
}
HeightMap read_x3p(const MeasuredSource& source) { refuse_packed(source.path, "a zip archive"); }

}  // namespace aberfit
