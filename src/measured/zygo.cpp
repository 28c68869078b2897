// Zygo MetroPro .dat, binary and big-endian. The layout is not published. The offsets are those on which
// prysm (prysm/io.py), Gwyddion (modules/file/metropro.c) and SurfaceTopography (IO/MetroPro.py) agree.
#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::int32_t kFirstInvalid = 2147483640;

// Returns the length of the header, which follows from its magic number.
std::size_t header_bytes(const FileBytes& file) {
  constexpr std::uint32_t kMagic = 0x881B036F;  // 036F, 0370, 0371: header formats 1, 2, 3
  const std::string allowed =
      "a MetroPro .dat, whose first four bytes are 0x881B036F, 0x881B0370 or 0x881B0371, big-endian";
  if (file.size() < 4) file.fail(0, fmt::format("a file of {} bytes", file.size()), allowed);
  const std::uint32_t magic = file.at<std::uint32_t>(0);
  const std::uint32_t reversed =
      (magic >> 24) | ((magic >> 8) & 0xff00u) | ((magic << 8) & 0xff0000u) | (magic << 24);
  if (reversed - kMagic <= 2)
    file.fail(0,
              fmt::format("0x{:08X}, a magic number with its bytes in reverse (little-endian) order", magic),
              allowed);
  if (magic - kMagic > 2) file.fail(0, fmt::format("0x{:08X}", magic), allowed);
  const std::size_t bytes = magic - kMagic == 2 ? 4096 : 834;
  if (file.size() < bytes)
    file.fail(0, fmt::format("a file of {} bytes", file.size()), fmt::format("a header of {} bytes", bytes));
  if (file.at<std::uint32_t>(6) != bytes)
    file.fail(6, fmt::format("header size {}", file.at<std::uint32_t>(6)),
              fmt::format("{}, as 0x{:08X} means", bytes, magic));
  return bytes;
}

// Returns the position of the first phase value, after the header and the intensity frames.
std::size_t phase_position(const FileBytes& file, std::size_t header, std::uint64_t phase_bytes) {
  const std::uint64_t frames = std::max<std::uint32_t>(1, file.at<std::uint16_t>(56));
  const std::uint64_t intensity =
      2ull * file.at<std::uint16_t>(52) * file.at<std::uint16_t>(54) * frames;  // < 2^49
  const std::uint64_t needed = header + intensity + phase_bytes;
  if (needed > file.size())
    file.fail(file.size(), fmt::format("the end of the file, {} bytes too early", needed - file.size()),
              fmt::format("header {} + intensity {} x {} x {} x 2 + phase {} x {} x 4 bytes", header,
                          file.at<std::uint16_t>(52), file.at<std::uint16_t>(54), frames,
                          file.at<std::uint16_t>(68), file.at<std::uint16_t>(70)));
  return std::size_t(header + intensity);
}

// Height of one count, S O W / R [m]: scale factor, obliquity factor, wavelength over phase resolution.
double height_per_count(const FileBytes& file, const MeasuredSource& source) {
  const double scale = file.at<float>(164), obliquity = file.at<float>(176);
  if (!std::isfinite(scale) || scale == 0)
    file.fail(164, fmt::format("interferometric scale factor {}", scale), "a number other than 0, often 0.5");
  if (!std::isfinite(obliquity) || obliquity == 0)
    file.fail(176, fmt::format("obliquity factor {}", obliquity), "a number other than 0, usually 1");
  // Limits in metres. A value outside is a wavelength in another unit, or damage.
  constexpr double kShortest = 1e-9, kLongest = 1e-3;
  const double said = file.at<float>(168);
  const bool sane = said >= kShortest && said <= kLongest;
  constexpr const char* kAllowed = "1e-9 to 1e-3 m, or option 'wavelength'";
  if (said == 0 && !source.wavelength)
    throw MissingFact("wavelength", source.path, "byte 168", "wavelength 0 m", kAllowed);
  if (!sane && !source.wavelength) file.fail(168, fmt::format("wavelength {} m", said), kAllowed);
  const double wavelength = *agreed_length(source.path, "wavelength", source.wavelength,
                                           sane ? std::optional(said) : std::nullopt, kSameWavelength);
  constexpr double kCountsPerWave[] = {4096, 32768, 131072};
  const std::uint32_t resolution = file.at<std::uint16_t>(218);
  if (resolution > 2) file.fail(218, fmt::format("phase resolution {}", resolution), "0, 1 or 2");
  return scale * obliquity * wavelength / kCountsPerWave[resolution] *
         (file.at<std::uint16_t>(232) != 0 ? -1 : 1);
}

double pitch(const FileBytes& file, const MeasuredSource& source) {
  const double resolution = file.at<float>(184);
  if (!std::isfinite(resolution) || resolution < 0)
    file.fail(184, fmt::format("lateral resolution {} m", resolution), "0 (unknown) or more");
  if (resolution == 0) return source.pitch.value_or(0);
  return *agreed_length(source.path, "pitch", source.pitch, resolution, kSamePitch);
}

}  // namespace

HeightMap read_zygo(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string bytes = read_map_bytes(source.path);
  const FileBytes file(source.path, bytes, std::endian::big);
  const std::size_t header = header_bytes(file);
  const std::uint32_t columns = file.at<std::uint16_t>(68), rows = file.at<std::uint16_t>(70);
  if (columns == 0 || rows == 0)
    file.fail(68, fmt::format("phase data of {} x {} points", columns, rows), "at least 1 x 1");
  const std::uint64_t phase_bytes = 4ull * columns * rows;
  const std::uint32_t said = file.at<std::uint32_t>(72);
  if (said != 0 && said != phase_bytes)
    file.fail(72, fmt::format("{} bytes of phase", said),
              fmt::format("{}, as {} x {} points have", phase_bytes, columns, rows));
  const std::size_t first = phase_position(file, header, phase_bytes);
  // With the scale factor (0.5 for a mirror at normal incidence) the heights are those of the surface.
  agreed_wavefront(source.path, source.wavefront, false);
  const double factor = height_per_count(file, source);

  const double p = pitch(file, source);
  HeightMap map = empty_map(rows, columns, p, p);
  const std::string_view comment = file.text(80, 82);
  map.label = one_line(comment.substr(0, comment.find('\0')), 82);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const std::int32_t count = file.at<std::int32_t>(first + 4 * (row * columns + column));
      // The file starts with the top row.
      if (count < kFirstInvalid) map.height(rows - 1 - row, column) = factor * count;
    }
  return map;
}

}  // namespace aberfit
