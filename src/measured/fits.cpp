// FITS images of heights or wavefronts.
#include <fitsio.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/units.h"
#include "fits_layout.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

std::string message(int status) {
  char text[FLEN_STATUS] = "";
  fits_get_errstatus(status, text);
  return fmt::format("CFITSIO error {} ({})", status, text);
}

// CFITSIO on bytes in memory: no path ever meets its extended file names.
class MemoryFits {
 public:
  MemoryFits(const std::string& path, std::string* bytes)
      : path_(path), buffer_(bytes->data()), size_(bytes->size()) {
    int status = 0;
    fits_open_memfile(&file_, "memory", READONLY, &buffer_, &size_, 0, nullptr, &status);
    check(status, "");
  }
  ~MemoryFits() {
    int ignored = 0;
    if (file_ != nullptr) fits_close_file(file_, &ignored);
    fits_clear_errmsg();
  }
  MemoryFits(const MemoryFits&) = delete;
  MemoryFits& operator=(const MemoryFits&) = delete;

  fitsfile* get() const { return file_; }
  void check(int status, const std::string& key) const {
    if (status != 0) throw InputError(path_, key, message(status), "a FITS image that keeps to the standard");
  }
  std::optional<std::string> text(const char* key) const {
    char value[FLEN_VALUE] = "";
    int status = 0;
    fits_read_key(file_, TSTRING, key, value, nullptr, &status);
    if (absent(status)) return std::nullopt;
    check(status, key);
    return one_line(value, FLEN_VALUE);
  }
  std::optional<double> positive(const char* key) const {
    const std::optional<double> value = number(key);
    if (value && !(*value > 0 && std::isfinite(*value)))
      throw InputError(path_, key, fmt::format("{}", *value), "a positive number [m]");
    return value;
  }
  /// Without its sign, as of an axis that runs to the left; nothing for 0.
  std::optional<double> size(const char* key) const {
    const std::optional<double> value = number(key);
    if (!value || *value == 0 || !std::isfinite(*value)) return std::nullopt;
    return std::abs(*value);
  }

  /// Where CFITSIO sees the data of the unit it is at must be inside what it has: it reads on without a look
  /// at the end.
  void require_data_inside() const {
    LONGLONG header = 0, data = 0, end = 0;
    int status = 0;
    fits_get_hduaddrll(file_, &header, &data, &end, &status);
    check(status, "image");
    if (data < 0 || end < data || std::uint64_t(end) > size_)
      throw InputError(
          path_, "NAXISn",
          fmt::format("data to byte {} in one reading of the header, to byte {} in another", end, size_),
          "a header without ambiguous keys");
  }
  /// BSCALE and BZERO must be numbers of use; CFITSIO takes a scale of 0 and makes one value of all pixels.
  void require_scale() const {
    for (const char* key : {"BSCALE", "BZERO"}) {
      const double value = number(key).value_or(1);
      const bool scale = std::string_view(key) == "BSCALE";
      if (!std::isfinite(value) || (scale && value == 0))
        throw InputError(path_, key, fmt::format("{}", value),
                         scale ? "a number other than 0" : "a finite number");
    }
  }

 private:
  static bool absent(int status) { return status == KEY_NO_EXIST || status == VALUE_UNDEFINED; }
  std::optional<double> number(const char* key) const {
    double value = 0;
    int status = 0;
    fits_read_key(file_, TDOUBLE, key, &value, nullptr, &status);
    if (absent(status)) return std::nullopt;
    check(status, key);
    return value;
  }

  const std::string& path_;
  void* buffer_;
  std::size_t size_;
  fitsfile* file_ = nullptr;
};

enum class Unit { kMetre, kRadian, kWave };

// [m] (or the unit itself) per unit of the file.
std::pair<double, Unit> unit_of(const std::string& path, const char* key, std::string text) {
  text = lower_case(text);
  const std::string found = in_quotes(text);
  if (text.size() > 1 && text.ends_with('s')) text.pop_back();
  if (const auto metres = metres_per_unit(text)) return {*metres, Unit::kMetre};
  if (text == "rad" || text == "radian") return {1, Unit::kRadian};
  if (text == "wave" || text == "wavelength") return {1, Unit::kWave};
  throw InputError(path, key, found, "m, mm, um, micron, nm, pm, radian or wave, or option 'value_unit'");
}

// What one unit of the image is in metres: of the wavefront, or of the surface where that is what was
// measured.
double metres_per_value(const MeasuredSource& source, const MemoryFits& file) {
  // BUNIT is the standard's; Z_UNIT is what PROPER's prop_writemap writes.
  std::optional<std::pair<double, Unit>> unit;
  std::string name;
  for (const char* key : {"BUNIT", "Z_UNIT"}) {
    const std::optional<std::string> text = unit ? std::nullopt : file.text(key);
    if (!text || text->empty()) continue;
    try {
      unit = unit_of(source.path, key, *text);
      name = *text;
    } catch (const InputError&) {
      if (!source.value_factor && !source.value_in_waves) throw;  // the option says it
    }
  }
  if (!unit && source.value_in_waves) unit = {1, Unit::kWave};
  if (!unit && !source.value_factor)
    throw MissingFact("value_unit", source.path, "BUNIT", "no unit of the values",
                      "the key BUNIT, or option 'value_unit'");
  if (!unit) return *source.value_factor;
  const Unit kind = unit->second;
  if (source.value_in_waves && kind != Unit::kWave)
    refuse_option(source.path, "value_unit", "waves", in_quotes(name));
  double factor = unit->first;
  if (kind == Unit::kMetre)
    return agreed_factor(source.path, "value_unit", source.value_factor, factor, name);
  if (source.value_factor)  // a length where the file has a phase
    refuse_option(source.path, "value_unit", "a length", in_quotes(name));
  if (!source.wavelength)
    throw MissingFact("wavelength", source.path, "BUNIT", kind == Unit::kRadian ? "radians" : "waves",
                      "a length, or option 'wavelength'");
  if (kind == Unit::kRadian) factor /= 2 * std::numbers::pi;
  return factor * *source.wavelength;
}

// MAPTYPE is what PROPER's prop_writemap writes; elsewhere the option has to say it.
bool is_wavefront(const MeasuredSource& source, const MemoryFits& file) {
  if (const std::optional<std::string> type = file.text("MAPTYPE"); type && !type->empty()) {
    const std::string word = lower_case(*type);
    if (word == "wavefront") return agreed_wavefront(source.path, source.wavefront, true);
    if (word == "mirror" || word == "surface") return agreed_wavefront(source.path, source.wavefront, false);
    throw InputError(source.path, "MAPTYPE", in_quotes(*type),
                     "wavefront or mirror: heights; a map of amplitudes has none");
  }
  if (!source.wavefront)
    throw MissingFact(
        "of", source.path, "option 'of'", "nothing",
        "wavefront (heights of a reflected wavefront) or surface; only the key MAPTYPE of PROPER "
        "says it");
  return *source.wavefront;
}

double pitch(const MeasuredSource& source, const MemoryFits& file) {
  // POPPY's two and PROPER's; PIXSCALE is left alone, it is an angle as often as a length.
  for (const char* key : {"PIXELSCL", "PUPLSCAL", "PIXSIZE"})
    if (const auto value = file.positive(key))
      return *agreed_length(source.path, "pitch", source.pitch, value, kSamePitch);
  return source.pitch.value_or(0);
}

// The first slice of the unit CFITSIO is at, NaN where it is blank. BSCALE, BZERO and BLANK are applied by
// CFITSIO.
Grid pixels(const std::string& path, const MemoryFits& file, const FitsImage& image) {
  int dimensions = 0, status = 0;
  fits_get_img_dim(file.get(), &dimensions, &status);
  file.check(status, "NAXIS");
  std::vector<LONGLONG> size(std::size_t(std::max(dimensions, 2)), 0), first(size.size(), 1);
  fits_get_img_sizell(file.get(), dimensions, size.data(), &status);
  file.check(status, "NAXISn");
  if (size[0] != image.columns || size[1] != image.rows)
    throw InputError(path, "NAXISn",
                     fmt::format("{} x {} pixels in one reading of the header, {} x {} in another", size[0],
                                 size[1], image.columns, image.rows),
                     "a header without ambiguous keys");
  file.require_data_inside();
  file.require_scale();
  Grid values(image.rows, image.columns);
  double invalid = std::numeric_limits<double>::quiet_NaN();
  int any_invalid = 0;
  fits_read_pixll(file.get(), TDOUBLE, first.data(), image.columns * image.rows, &invalid, values.data(),
                  &any_invalid, &status);
  file.check(status, "image");
  return values;
}

// The pixels, NaN where they are not finite or left out by a mask; CFITSIO is at that one afterwards.
Grid valid_pixels(const std::string& path, const MemoryFits& file, const FitsImage& image) {
  constexpr double kInvalid = std::numeric_limits<double>::quiet_NaN();
  Grid values = pixels(path, file, image);
  values = values.isFinite().select(values, kInvalid);
  if (image.mask_hdu != 0) {
    // As fits_opd_bytes writes it: 0 where there is no measurement.
    int status = 0;
    fits_movabs_hdu(file.get(), image.mask_hdu, nullptr, &status);
    file.check(status, fmt::format("header {}", image.mask_hdu));
    values = (pixels(path, file, image) != 0).select(values, kInvalid);
  }
  return values;
}

// What `use(file, image)` makes of a file, with CFITSIO at its image.
template <class Use>
auto at_image(const std::string& path, const Use& use) {
  std::string bytes = read_map_bytes(path);
  const FitsImage image = find_fits_image(path, bytes);
  // Only what was checked goes to CFITSIO, with the last block filled up, as it reads whole blocks.
  constexpr std::uint64_t kBlock = 2880;
  bytes.resize(std::size_t((image.end + kBlock - 1) / kBlock * kBlock), '\0');
  const MemoryFits file(path, &bytes);
  int status = 0;
  fits_movabs_hdu(file.get(), image.hdu, nullptr, &status);
  file.check(status, fmt::format("header {}", image.hdu));
  return use(file, image);
}

}  // namespace

Grid internal::fits_pixels(const std::string& path) {
  return at_image(
      path, [&](const MemoryFits& file, const FitsImage& image) { return valid_pixels(path, file, image); });
}

HeightMap read_fits(const MeasuredSource& source) {
  require_sane_options(source);
  return at_image(source.path, [&](const MemoryFits& file, const FitsImage& image) {
    const double halve = surface_per_height(is_wavefront(source, file));
    const double factor = halve * metres_per_value(source, file);
    const double p = pitch(source, file);
    // Row 0 of FITS is the lowest, as ours is.
    HeightMap map = empty_map(image.rows, image.columns, p, p);
    if (const auto name = file.text("OBJECT")) map.label = *name;
    map.height = factor * valid_pixels(source.path, file, image);
    map.file_unit = factor;
    return map;
  });
}

namespace {

// [m] or [rad] of a pixel: PIXELSCL of POPPY's images [arcsec], or the axis of the standard.
void read_pixel(const MemoryFits& file, FocalImage* image) {
  if (const auto scale = file.positive("PIXELSCL")) {
    image->pixel = *scale * unit_factor("arcsec", Dimension::kAngle);
    image->is_angle = true;
    return;
  }
  const std::optional<std::string> unit = file.text("CUNIT1");
  const std::optional<double> step = unit ? file.size("CDELT1") : std::nullopt;
  if (!step) return;
  if (const auto metres = metres_per_unit(*unit)) {
    image->pixel = *metres * *step;
    return;
  }
  try {
    image->pixel = unit_factor(*unit, Dimension::kAngle) * *step;
    image->is_angle = true;
  } catch (const UnitError&) {  // of no length and no angle: the study has to say it
  }
}

}  // namespace

FocalImage internal::read_fits_image(const std::string& path) {
  return at_image(path, [&](const MemoryFits& file, const FitsImage& found) {
    FocalImage image;
    read_pixel(file, &image);
    image.light = valid_pixels(path, file, found);
    return image;
  });
}

}  // namespace aberfit
