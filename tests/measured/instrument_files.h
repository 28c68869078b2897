#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "aberfit/measured/read_measurement.h"
#include "map_samples.h"

namespace aberfit::test {

/// A file written by write_instrument_files.py.
inline std::string instrument_file(const std::string& name) {
  return std::string(ABERFIT_TEST_DATA "/synthetic/") + name;
}

inline MeasuredSource map_source(const std::string& path) {
  MeasuredSource source;
  source.path = path;
  return source;
}

/// Expects the surface of those files and its two pitches. tolerance: of the heights [m].
inline void expect_marker(const HeightMap& map, double tolerance) {
  expect_same_map(map, marker_map(9, 12, 0.25e-3), tolerance);
  constexpr double kSingle = 1e-7;  // .opd stores pitches in single precision
  EXPECT_NEAR(map.pitch_x, 0.25e-3, kSingle * 0.25e-3);
  EXPECT_NEAR(map.pitch_y, 0.5e-3, kSingle * 0.5e-3);
  EXPECT_NEAR(map.x0, -5.5 * map.pitch_x, 1e-15);
  EXPECT_NEAR(map.y0, -4 * map.pitch_y, 1e-15);
}

/// Replaces `from`, which must occur, once.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Overwrites the bytes at a place with a number in the byte order of this machine.
template <class Number>
std::string with_number(std::string bytes, std::size_t place, Number number) {
  std::memcpy(bytes.data() + place, &number, sizeof number);
  return bytes;
}

}  // namespace aberfit::test
