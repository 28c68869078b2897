// FITS images of heights or wavefronts.
#include <fitsio.h>
#include <fmt/format.h>

#include <algorithm>
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
#include "gzip.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

std::string message(int status) {
  char text[FLEN_STATUS] = "";
  fits_get_errstatus(status, text);
  return fmt::format("CFITSIO error {} ({})", status, text);
}

// CFITSIO on bytes in memory, so that it never interprets a path by its extended file name syntax.
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
    if (status != 0)
      throw InputError(path_, key, message(status), "a FITS image that conforms to the standard");
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
  std::optional<double> number(const char* key) const {
    double value = 0;
    int status = 0;
    fits_read_key(file_, TDOUBLE, key, &value, nullptr, &status);
    if (absent(status)) return std::nullopt;
    check(status, key);
    return value;
  }
  void go_to(const FitsImage& image) const {
    int status = 0;
    fits_movabs_hdu(file_, image.hdu + 1, nullptr, &status);
    check(status, fmt::format("hdu {}", image.hdu));
  }

  /// Checks that the data of the current unit lie within the buffer; CFITSIO does not check the end.
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
  /// Checks that BSCALE and BZERO are usable. CFITSIO accepts a scale of 0, which makes all pixels equal.
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
  const std::string& path_;
  void* buffer_;
  std::size_t size_;
  fitsfile* file_ = nullptr;
};

enum class Unit { kMetre, kRadian, kWave };

// Returns [m] (or the unit itself) per unit of the file; nothing for a unit that heights cannot have.
std::optional<std::pair<double, Unit>> unit_of(std::string text) {
  text = lower_case(text);
  if (text.size() > 1 && text.ends_with('s')) text.pop_back();
  if (const auto metres = metres_per_unit(text)) return std::pair(*metres, Unit::kMetre);
  if (text == "rad" || text == "radian") return std::pair(1.0, Unit::kRadian);
  if (text == "wave" || text == "wavelength") return std::pair(1.0, Unit::kWave);
  return std::nullopt;
}

// Returns metres per unit of the image, of the wavefront or of the surface, whichever was measured.
double metres_per_value(const MeasuredSource& source, const MemoryFits& file) {
  // BUNIT is the standard key; PROPER's prop_writemap writes Z_UNIT.
  std::optional<std::pair<double, Unit>> unit;
  std::string name;
  for (const char* key : {"BUNIT", "Z_UNIT"}) {
    const std::optional<std::string> text = unit ? std::nullopt : file.text(key);
    if (!text || text->empty()) continue;
    name = *text;
    unit = unit_of(name);
    if (!unit && !source.value_factor && !source.value_in_waves)  // otherwise the option gives the unit
      throw InputError(source.path, key, in_quotes(name),
                       "m, mm, um, micron, nm, pm, radian or wave, or option 'value_unit'");
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
  if (source.value_factor)  // a length contradicts a phase in the file
    refuse_option(source.path, "value_unit", "a length", in_quotes(name));
  if (!source.wavelength)
    throw MissingFact("wavelength", source.path, "BUNIT", kind == Unit::kRadian ? "radians" : "waves",
                      "a length, or option 'wavelength'");
  if (kind == Unit::kRadian) factor /= 2 * std::numbers::pi;
  return factor * *source.wavelength;
}

// PROPER's prop_writemap and our own export write MAPTYPE. For other words ("measured") the option decides.
bool is_wavefront(const MeasuredSource& source, const MemoryFits& file) {
  const std::string type = file.text("MAPTYPE").value_or(""), word = lower_case(type);
  if (word == "wavefront") return agreed_wavefront(source.path, source.wavefront, true);
  if (word == "mirror" || word == "surface") return agreed_wavefront(source.path, source.wavefront, false);
  if (word == "amplitude")
    throw InputError(source.path, "MAPTYPE", in_quotes(type),
                     "wavefront or mirror (amplitudes are not heights)");
  if (!source.wavefront)
    throw MissingFact(
        "of", source.path, "option 'of'",
        type.empty() ? "nothing" : fmt::format("nothing, and MAPTYPE {} does not state it", in_quotes(type)),
        "wavefront (heights of a reflected wavefront) or surface; in the file by MAPTYPE 'wavefront' or "
        "'mirror'");
  return *source.wavefront;
}

// Returns the step along an axis in the unit of the axis, negative if the axis runs backwards. It comes from
// the column of the matrix CD, otherwise from CDELTn; nothing if the file has neither.
std::optional<double> axis_step(const MemoryFits& file, int axis) {
  const auto matrix = [&](int row) {
    return file.number(fmt::format("CD{}_{}", row, axis).c_str()).value_or(0);
  };
  double step = std::copysign(std::hypot(matrix(1), matrix(2)), matrix(axis));
  if (step == 0) step = file.number(fmt::format("CDELT{}", axis).c_str()).value_or(0);
  return step != 0 && std::isfinite(step) ? std::optional(step) : std::nullopt;
}

bool axes_are_turned(const MemoryFits& file) {
  for (const char* key : {"CD1_2", "CD2_1", "PC1_2", "PC2_1", "CROTA2"})
    if (file.number(key).value_or(0) != 0) return true;
  return false;
}

// Steps along x and y [m], negative if an axis runs backwards; 0: the file does not state it.
struct Steps {
  double x = 0, y = 0;
};
Steps steps_of(const MemoryFits& file) {
  // Keys of POPPY (two) and PROPER. PIXSCALE is not used because it can be an angle as well as a length.
  for (const char* key : {"PIXELSCL", "PUPLSCAL", "PIXSIZE"})
    if (const auto value = file.positive(key)) return {*value, *value};
  // The standard's keys are used if the axes are lengths along x and y.
  if (axes_are_turned(file)) return {};
  const auto metres = [&](int axis) {
    const auto unit = metres_per_unit(file.text(fmt::format("CUNIT{}", axis).c_str()).value_or(""));
    return unit ? *unit * axis_step(file, axis).value_or(0) : 0.0;
  };
  return {metres(1), metres(2)};
}

// Reads a plane (from 0) of the current unit; blank pixels are NaN. CFITSIO applies BSCALE, BZERO and BLANK.
Grid pixels(const std::string& path, const MemoryFits& file, const FitsImage& image, std::int64_t plane) {
  int dimensions = 0, status = 0;
  fits_get_img_dim(file.get(), &dimensions, &status);
  file.check(status, "NAXIS");
  std::vector<LONGLONG> size(std::size_t(std::max(dimensions, 2)), 0), first(size.size(), 1);
  fits_get_img_sizell(file.get(), dimensions, size.data(), &status);
  file.check(status, "NAXISn");
  LONGLONG planes = 1;
  for (std::size_t axis = 2; axis < size.size(); ++axis) {
    first[axis] = 1 + plane / planes % std::max<LONGLONG>(size[axis], 1);
    planes *= std::max<LONGLONG>(size[axis], 1);
  }
  if (size[0] != image.columns || size[1] != image.rows || planes != image.planes)
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

struct FitsChoice {
  FitsImage image;
  std::optional<FitsImage> mask;
  std::int64_t plane = 0;  // from 0
  Warnings warnings;       // choices made without an option
};

// Returns the pixels, NaN where they are not finite or masked. CFITSIO may be at the mask afterwards.
Grid valid_pixels(const std::string& path, const MemoryFits& file, const FitsChoice& choice) {
  constexpr double kInvalid = std::numeric_limits<double>::quiet_NaN();
  Grid values = pixels(path, file, choice.image, choice.plane);
  values = values.isFinite().select(values, kInvalid);
  if (choice.mask) {
    // In a mask 0 means no measurement, as in fits_opd_bytes. For a cube it may have as many planes.
    file.go_to(*choice.mask);
    const std::int64_t plane = choice.mask->planes == choice.image.planes ? choice.plane : 0;
    values = (pixels(path, file, *choice.mask, plane) != 0).select(values, kInvalid);
  }
  return values;
}

// Returns the images that are not the mask of another image.
std::vector<FitsImage> candidates(const std::vector<FitsImage>& images) {
  std::vector<FitsImage> found;
  for (const FitsImage& image : images)
    if (!image.is_mask() || std::none_of(images.begin(), images.end(), [&](const FitsImage& other) {
          return !other.is_mask() && other.columns == image.columns && other.rows == image.rows;
        }))
      found.push_back(image);
  return found;
}

FitsChoice first_image(const std::vector<FitsImage>& images) {
  return {candidates(images).front(), std::nullopt, 0, {}};
}

FitsImage named_image(const MeasuredSource& source, const std::vector<FitsImage>& images) {
  const auto number = parse_number<int>(*source.hdu);
  std::vector<FitsImage> found;
  for (const FitsImage& image : images)
    if (number ? image.hdu == *number : lower_case(image.name) == lower_case(*source.hdu))
      found.push_back(image);
  if (found.size() == 1) return found.front();
  throw InputError(source.path, "option 'hdu'",
                   found.empty() ? in_quotes(*source.hdu)
                                 : fmt::format("{} images named {}", found.size(), in_quotes(*source.hdu)),
                   "the name or the number of one of the images " + fits_image_list(images));
}

// Chooses the image of heights: the named one, the only one, or the only one with a unit of heights.
FitsChoice chosen_image(const MeasuredSource& source, const std::vector<FitsImage>& images) {
  FitsChoice choice;
  const std::vector<FitsImage> all = candidates(images);
  std::vector<FitsImage> with_unit;
  for (const FitsImage& image : all)
    if (unit_of(image.unit)) with_unit.push_back(image);
  if (source.hdu)
    choice.image = named_image(source, images);
  else if (all.size() == 1)
    choice.image = all.front();
  else if (with_unit.size() == 1) {
    choice.image = with_unit.front();
    choice.warnings.push_back(
        {"image-chosen", fmt::format("of the images {}, hdu {} is read, because only its unit is one of "
                                     "heights; option 'hdu' selects another",
                                     fits_image_list(all), choice.image.hdu)});
  } else
    throw MissingFact("hdu", source.path, "", "images " + fits_image_list(all),
                      "option 'hdu': the name or the number of one of them",
                      fmt::format("{}", all.front().hdu));
  const std::int64_t planes = choice.image.planes;
  if (!source.plane && planes > 1)
    throw MissingFact("plane", source.path, fmt::format("hdu {}", choice.image.hdu),
                      fmt::format("a cube of {} planes", planes), "option 'plane', from 1 on");
  choice.plane = source.plane.value_or(1) - 1;
  if (choice.plane < 0 || choice.plane >= planes)
    throw InputError(source.path, "option 'plane'", fmt::format("{}", choice.plane + 1),
                     planes == 1 ? "1, the only plane" : fmt::format("a plane from 1 to {}", planes));
  return choice;
}

// Returns use(file, choice) for a file, gzipped or not, with CFITSIO at the image of choose(images).
template <class Choose, class Use>
auto at_image(const std::string& path, const Choose& choose, const Use& use) {
  std::string bytes = read_map_bytes(path);
  if (is_gzip(bytes)) {
    bytes = unpacked_gzip(path, bytes);
    if (!bytes.starts_with("SIMPLE  ="))
      throw InputError(path, "", "a gzip file whose content is not a FITS file",
                       "a FITS file; unpack other files with gunzip");
  }
  const std::vector<FitsImage> images = find_fits_images(path, bytes);
  FitsChoice choice = choose(images);
  if (const FitsImage* mask = mask_of(choice.image, images)) choice.mask = *mask;
  // CFITSIO gets only the checked bytes, with a padded last block because it reads whole blocks.
  constexpr std::uint64_t kBlock = 2880;
  const std::uint64_t end = std::max(choice.image.end, choice.mask ? choice.mask->end : 0);
  bytes.resize(std::size_t((end + kBlock - 1) / kBlock * kBlock), '\0');
  const MemoryFits file(path, &bytes);
  file.go_to(choice.image);
  return use(file, choice);
}

}  // namespace

Grid internal::fits_pixels(const std::string& path) {
  return at_image(path, first_image, [&](const MemoryFits& file, const FitsChoice& choice) {
    return valid_pixels(path, file, choice);
  });
}

HeightMap read_fits(const MeasuredSource& source) {
  require_sane_options(source);
  const auto choose = [&](const std::vector<FitsImage>& images) { return chosen_image(source, images); };
  return at_image(source.path, choose, [&](const MemoryFits& file, const FitsChoice& choice) {
    const double halve = surface_per_height(is_wavefront(source, file));
    const double factor = halve * metres_per_value(source, file);
    const Steps steps = steps_of(file);
    // FITS has the lowest row first, as we do, unless the step is negative.
    HeightMap map =
        empty_map(choice.image.rows, choice.image.columns, agreed_pitch(source, std::abs(steps.x)),
                  agreed_pitch(source, std::abs(steps.y)));
    map.warnings = choice.warnings;
    if (const auto name = file.text("OBJECT")) map.label = *name;
    map.height = factor * valid_pixels(source.path, file, choice);
    map.file_unit = factor;
    if (steps.x < 0) map.height = map.height.rowwise().reverse().eval();
    if (steps.y < 0) map.height = map.height.colwise().reverse().eval();
    return map;
  });
}

namespace {

// Reads the pixel size [m] or [rad] from PIXELSCL (POPPY, [arcsec]), or from CDELT1 or CD1_1 with CUNIT1.
void read_pixel(const MemoryFits& file, FocalImage* image) {
  if (const auto scale = file.positive("PIXELSCL")) {
    image->pixel = *scale * unit_factor("arcsec", Dimension::kAngle);
    image->is_angle = true;
    return;
  }
  const std::optional<std::string> unit = file.text("CUNIT1");
  const std::optional<double> step = unit ? axis_step(file, 1) : std::nullopt;
  if (!step) return;
  if (const auto metres = metres_per_unit(*unit)) {
    image->pixel = *metres * std::abs(*step);
    return;
  }
  try {
    image->pixel = unit_factor(*unit, Dimension::kAngle) * std::abs(*step);
    image->is_angle = true;
  } catch (const UnitError&) {  // neither a length nor an angle: the study must give the pixel size
  }
}

}  // namespace

FocalImage internal::read_fits_image(const std::string& path) {
  return at_image(path, first_image, [&](const MemoryFits& file, const FitsChoice& choice) {
    FocalImage image;
    read_pixel(file, &image);
    image.light = valid_pixels(path, file, choice);
    return image;
  });
}

}  // namespace aberfit
