// Writes FITS: images in double precision, and OPD files of POPPY (poppy/poppy_core.py, FITSOpticalElement).
#include "aberfit/measured/write_fits.h"

#include <fitsio.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <stdexcept>

#include "aberfit/core/overloaded.h"
#include "aberfit/measured/write_map.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

using ByteGrid = Eigen::Array<unsigned char, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A file in memory. After the first failure later calls do nothing, and `bytes` throws the error.
class FitsWriter {
 public:
  FitsWriter() { fits_create_memfile(&file_, &buffer_, &size_, 1 << 20, &FitsWriter::grow, &status_); }
  ~FitsWriter() {
    close();
    std::free(buffer_);
    fits_clear_errmsg();
  }
  FitsWriter(const FitsWriter&) = delete;
  FitsWriter& operator=(const FitsWriter&) = delete;

  void begin_image(int bits, Eigen::Index rows, Eigen::Index columns) {
    long axes[2] = {long(columns), long(rows)};
    fits_create_img(file_, bits, rows == 1 ? 1 : 2, axes, &status_);
  }
  void card(const FitsCard& card) {
    const char* key = card.key.c_str();
    const char* comment = card.comment.c_str();
    std::visit(
        Overloaded{
            [&](double value) { fits_write_key(file_, TDOUBLE, key, &value, comment, &status_); },
            [&](std::int64_t value) {
              LONGLONG number = value;
              fits_write_key(file_, TLONGLONG, key, &number, comment, &status_);
            },
            [&](std::string value) { fits_write_key(file_, TSTRING, key, value.data(), comment, &status_); }},
        card.value);
  }
  void pixels(const Grid& values) {
    fits_write_img(file_, TDOUBLE, 1, values.size(), const_cast<double*>(values.data()), &status_);
  }
  void pixels(const ByteGrid& values) {
    fits_write_img(file_, TBYTE, 1, values.size(), const_cast<unsigned char*>(values.data()), &status_);
  }
  std::string bytes() {
    LONGLONG end = 0;
    fits_flush_file(file_, &status_);
    fits_get_hduaddrll(file_, nullptr, nullptr, &end, &status_);
    if (status_ != 0 || std::size_t(end) > size_) {
      char text[FLEN_STATUS] = "";
      fits_get_errstatus(status_, text);
      throw std::runtime_error(fmt::format("FITS: CFITSIO error {} ({})", status_, text));
    }
    close();  // closing may move the buffer
    return std::string(static_cast<const char*>(buffer_), std::size_t(end));
  }

 private:
  static void* grow(void* old, std::size_t bytes) { return std::realloc(old, bytes); }
  void close() {
    int ignored = 0;
    if (file_ != nullptr) fits_close_file(file_, &ignored);
    file_ = nullptr;
  }

  fitsfile* file_ = nullptr;
  void* buffer_ = nullptr;
  std::size_t size_ = 0;
  int status_ = 0;
};

}  // namespace

std::string fits_bytes(const std::vector<FitsImageUnit>& images) {
  FitsWriter file;
  for (const FitsImageUnit& image : images) {
    file.begin_image(DOUBLE_IMG, image.values.rows(), image.values.cols());
    if (!image.name.empty()) file.card({"EXTNAME", image.name, ""});
    for (const FitsCard& card : image.cards) file.card(card);
    file.pixels(image.values);
  }
  return file.bytes();
}

std::string fits_opd_bytes(const HeightMap& map) {
  constexpr double kEqual = 1e-6;
  if (!(map.pitch_x > 0 && map.pitch_y > 0))
    throw std::invalid_argument("FITS OPD: the pitch of the map is unknown");
  if (std::abs(map.pitch_x / map.pitch_y - 1) > kEqual)
    throw std::invalid_argument("FITS OPD: the format has one pixel scale, but the map has two");
  const Eigen::Index side = std::max(map.rows(), map.columns());
  const Eigen::Index row0 = (side - map.rows()) / 2, column0 = (side - map.columns()) / 2;
  Grid opd = Grid::Zero(side, side);
  ByteGrid mask = ByteGrid::Zero(side, side);
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      if (const double h = map.height(row, column); std::isfinite(h)) {
        opd(row0 + row, column0 + column) = 2 * h;
        mask(row0 + row, column0 + column) = 1;
      }

  FitsWriter file;
  file.begin_image(DOUBLE_IMG, side, side);
  file.card({"BUNIT", std::string("meter"), "optical path difference, 2 x surface height"});
  file.card({"MAPTYPE", std::string("wavefront"), "heights of the reflected wavefront"});
  file.card({"PIXELSCL", map.pitch_x, "[m] per pixel"});
  if (const std::string label = one_line(map.label, 68); !label.empty()) file.card({"OBJECT", label, ""});
  file.pixels(opd);
  // POPPY reads the first image and ignores this one.
  file.begin_image(BYTE_IMG, side, side);
  file.card({"EXTNAME", std::string("MASK"), "1: measured, 0: outside or no data"});
  file.pixels(mask);
  return file.bytes();
}

}  // namespace aberfit
