#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"
#include "file_options.h"

// Functions that all readers of height maps share: bytes, lines and the options of every map.

namespace aberfit::internal {

/// Largest number of points of a map. A larger one indicates a damaged header.
inline constexpr std::int64_t kMostMapPoints = 1'000'000'000;

/// Largest ratio of unpacked to packed size that deflate can reach.
inline constexpr std::uint64_t kMostByDeflate = 1032;

/// Returns the whole file. Throws InputError if it is not a readable regular file.
inline std::string read_map_bytes(const std::string& path) {
  std::optional<std::string> bytes = file_bytes(path);
  if (!bytes) throw InputError(path, "", "a file that cannot be read", "a readable file");
  return *std::move(bytes);
}

/// Numbers and text at byte positions of a binary file. Reading beyond the end throws InputError.
class FileBytes {
 public:
  FileBytes(const std::string& path, std::string_view bytes, std::endian order)
      : path_(path), bytes_(bytes), order_(order) {}

  template <class Number>
  Number at(std::uint64_t place) const {
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), text(place, raw.size()).data(), raw.size());
    if (order_ != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
  }
  std::string_view text(std::uint64_t place, std::uint64_t length) const {
    if (!holds(place, length))
      fail(size(), "the end of the file", fmt::format("{} bytes that begin at byte {}", length, place));
    return bytes_.substr(std::size_t(place), std::size_t(length));
  }
  bool holds(std::uint64_t place, std::uint64_t length) const {
    return place <= size() && length <= size() - place;
  }
  std::uint64_t size() const { return bytes_.size(); }
  /// Other bytes of the same file: a part of these bytes, or a copy.
  FileBytes part(std::uint64_t place, std::uint64_t length) const { return with(text(place, length)); }
  FileBytes with(std::string_view bytes) const { return FileBytes(path_, bytes, order_); }

  [[noreturn]] void fail(std::uint64_t place, const std::string& found, const std::string& allowed) const {
    throw InputError(path_, fmt::format("byte {}", place), found, allowed);
  }

 private:
  const std::string& path_;
  std::string_view bytes_;
  std::endian order_;
};

/// Returns one line of 7-bit text: other characters become spaces, the ends are trimmed.
inline std::string one_line(std::string_view text, std::size_t most) {
  std::string clean;
  for (const char c : text) clean += c >= 0x20 && c < 0x7f ? c : ' ';
  clean.erase(0, std::min(clean.find_first_not_of(' '), clean.size()));
  clean.resize(std::min(clean.size(), most));
  clean.erase(clean.find_last_not_of(' ') + 1);
  return clean;
}

/// Blanks and control characters, which separate the words of a map.
inline constexpr std::string_view kControls =
    "\x01\x02\x03\x04\x05\x06\a\b\t\n\v\f\r\x0e\x0f\x10\x11\x12\x13\x14\x15\x16\x17\x18\x19\x1a\x1b\x1c\x1d"
    "\x1e\x1f ";

/// Reads the next line that is neither blank nor a comment ('!').
inline bool next_with_content(TextLines* lines, std::string_view* line) {
  while (lines->next(line)) {
    const std::size_t first = line->find_first_not_of(kControls);
    if (first != std::string_view::npos && (*line)[first] != '!') return true;
  }
  return false;
}

inline void require_sane_options(const MeasuredSource& source) {
  check_option(source, source.pitch, "pitch", true);
  check_option(source, source.wavelength, "wavelength", true);
  check_option(source, source.value_factor, "value_unit", false);
}

inline void require_map_size(const std::string& path, const std::string& where, std::int64_t columns,
                             std::int64_t rows) {
  if (columns < 1 || rows < 1 || columns > kMostMapPoints || rows > kMostMapPoints / columns)
    throw InputError(path, where, fmt::format("a grid of {} x {} points", columns, rows),
                     fmt::format("1 to {} points", kMostMapPoints));
}

/// Returns the pitch [m] of the file if positive, otherwise of the option, otherwise 0 (unknown).
inline double agreed_pitch(const MeasuredSource& source, double said) {
  const bool known = said > 0 && std::isfinite(said);
  return agreed_length(source.path, "pitch", source.pitch, known ? std::optional(said) : std::nullopt,
                       kSamePitch)
      .value_or(0);
}

/// Returns metres per unit of length in any case: "um", "MICRON", "NanoMeters", "Angstrom".
inline std::optional<double> metres_per_unit(std::string_view unit) {
  for (const std::string& name : {std::string(unit), lower_case(unit)}) {
    try {
      return unit_factor(name, Dimension::kLength);
    } catch (const UnitError&) {
    }
  }
  return std::nullopt;
}

/// Returns a map of invalid points with the origin in its middle; pitch 0 means unknown.
inline HeightMap empty_map(Eigen::Index rows, Eigen::Index columns, double pitch_x, double pitch_y) {
  HeightMap map;
  map.height = Grid::Constant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  map.pitch_x = pitch_x;
  map.pitch_y = pitch_y;
  centre_on_grid(&map);
  return map;
}

}  // namespace aberfit::internal
