#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/measured/read_measurement.h"
#include "file_options.h"

// What the readers of height maps share: bytes, lines and the options that every map has.

namespace aberfit::internal {

/// Most points a map may have; more is a damaged header or no job for this program.
inline constexpr std::int64_t kMostMapPoints = 1'000'000'000;

/// The whole file. Throws InputError when it is no readable regular file.
inline std::string read_map_bytes(const std::string& path) {
  std::optional<std::string> bytes = file_bytes(path);
  if (!bytes) throw InputError(path, "", "a file that cannot be read", "a readable file");
  return *std::move(bytes);
}

/// One line of text for a file of 7-bit text: other characters become spaces, the ends are trimmed.
inline std::string one_line(std::string_view text, std::size_t most) {
  std::string clean;
  for (const char c : text) clean += c >= 0x20 && c < 0x7f ? c : ' ';
  clean.erase(0, std::min(clean.find_first_not_of(' '), clean.size()));
  clean.resize(std::min(clean.size(), most));
  clean.erase(clean.find_last_not_of(' ') + 1);
  return clean;
}

/// Blanks and control characters, which separate words of a map.
inline constexpr std::string_view kControls =
    "\x01\x02\x03\x04\x05\x06\a\b\t\n\v\f\r\x0e\x0f\x10\x11\x12\x13\x14\x15\x16\x17\x18\x19\x1a\x1b\x1c\x1d"
    "\x1e\x1f ";

/// The next line that is neither blank nor a comment ('!').
inline bool next_with_content(TextLines* lines, std::string_view* line) {
  while (lines->next(line)) {
    const std::size_t first = line->find_first_not_of(kControls);
    if (first != std::string_view::npos && (*line)[first] != '!') return true;
  }
  return false;
}

/// The options of every map.
inline void require_sane_options(const MeasuredSource& source) {
  check_option(source, source.pitch, "pitch", true);
  check_option(source, source.wavelength, "wavelength", true);
  check_option(source, source.value_factor, "value_unit", false);
}

/// A map of invalid points with its origin in the middle; pitch 0 means unknown.
inline HeightMap empty_map(Eigen::Index rows, Eigen::Index columns, double pitch_x, double pitch_y) {
  HeightMap map;
  map.height = Grid::Constant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  map.pitch_x = pitch_x;
  map.pitch_y = pitch_y;
  centre_on_grid(&map);
  return map;
}

}  // namespace aberfit::internal
