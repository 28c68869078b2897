#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/measured/height_map.h"

/// Measured files with known content, written from the descriptions of formats without code of readers.
namespace aberfit::test {

/// A DABAM pair: JSON metadata, and columns of numbers in the units of the file.
struct DabamFile {
  int format = 1;  ///< 1 slopes, 2 heights; 3 and 4 the same in pairs of columns
  std::vector<std::string> header;
  std::string keys = R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-6)";  ///< the factors and other keys
  std::string separator = " ";
  std::vector<std::vector<double>> rows;

  std::string metadata() const {
    return "{\n\"FILE_FORMAT\": " + std::to_string(format) +
           ",\n\"FILE_HEADER_LINES\": " + std::to_string(header.size()) +
           ",\n\"SURFACE_SHAPE\": \"made\", \"LENGTH\": \"\", \"YEAR_FABRICATION\": null,\n" + keys + "\n}\n";
  }
  std::string numbers() const {
    std::string text;
    for (const std::string& line : header) text += line + "\n";
    for (const std::vector<double>& row : rows) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        char field[32];
        std::snprintf(field, sizeof field, "%.17g", row[i]);
        text += (i == 0 ? "" : separator) + field;
      }
      text += "\n";
    }
    return text;
  }
  /// Writes <stem>.txt and <stem>.dat; returns the path of the first.
  template <class Folder>
  std::string write(const Folder& folder, const std::string& stem) const {
    folder.write(stem + ".dat", numbers());
    return folder.write(stem + ".txt", metadata());
  }
};

/// Uniform and normal numbers, the same on every platform: bits of a Mersenne twister, Box and Muller.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : bits_(seed) {}
  double uniform() { return double(bits_() >> 11) * 0x1p-53; }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 bits_;
};

/// A line over a surface and its exact slopes.
struct DrawnLine {
  std::vector<double> x, height, slope;  // [m], [m], [rad]
};

/// A realisation of the one-sided profile PSD `s1` [m^3] at the positions x: a direct sum of cosines at every
/// eighth of 1/length up to half the mean sampling rate, with normal amplitudes.
inline DrawnLine drawn_line(std::vector<double> x, const std::function<double(double)>& s1,
                            std::uint64_t seed) {
  DrawnLine line{std::move(x), {}, {}};
  const std::size_t n = line.x.size();
  line.height.assign(n, 0), line.slope.assign(n, 0);
  const double step = 1 / (8 * (line.x.back() - line.x.front()));
  Draws draws(seed);
  for (std::size_t wave = 0; wave < 4 * n; ++wave) {
    const double k = 2 * std::numbers::pi * (double(wave) + 0.5) * step;
    const double scale = std::sqrt(s1(k / (2 * std::numbers::pi)) * step);
    const double a = scale * draws.normal(), b = scale * draws.normal();
    for (std::size_t i = 0; i < n; ++i) {
      const double c = std::cos(k * line.x[i]), s = std::sin(k * line.x[i]);
      line.height[i] += a * c + b * s;
      line.slope[i] += k * (b * c - a * s);
    }
  }
  return line;
}

inline std::vector<double> even_positions(std::size_t n, double first, double pitch) {
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = first + pitch * double(i);
  return x;
}

inline void put_bytes(std::string* bytes, std::size_t at, std::uint32_t value, int width) {
  for (int i = 0; i < width; ++i) (*bytes)[at + std::size_t(i)] = char(value >> (8 * (width - 1 - i)));
}

/// A Zygo MetroPro .dat, written byte by byte from the table of offsets, big-endian.
struct MetroProFile {
  std::uint32_t magic = 0x881B0370, header_bytes = 834;
  std::uint32_t intensity_width = 0, intensity_height = 0, frames = 0;
  std::uint32_t columns = 4, rows = 3;
  float scale = 0.5f, wavelength = 6.328e-7f, obliquity = 1, lateral = 1e-4f;
  std::uint32_t phase_resolution = 1, sign = 0;
  std::string comment = "Sphere 7";
  /// Phase at (row from the top, column): by default 1000 counts per column, -100,000 per row; (0, 1) is
  /// invalid.
  std::function<std::int32_t(std::uint32_t, std::uint32_t)> count = [](std::uint32_t row,
                                                                       std::uint32_t column) {
    if (row == 0 && column == 1) return std::int32_t(2147483640);
    return std::int32_t(1000 * column) - std::int32_t(100000 * row);
  };

  std::string bytes() const {
    const std::size_t intensity = 2 * std::size_t(intensity_width) * intensity_height * std::max(1u, frames);
    std::string file(header_bytes + intensity + 4 * std::size_t(columns) * rows, '\0');
    const auto put_float = [&file](std::size_t at, float value) {
      put_bytes(&file, at, std::bit_cast<std::uint32_t>(value), 4);
    };
    put_bytes(&file, 0, magic, 4);
    put_bytes(&file, 6, header_bytes, 4);
    put_bytes(&file, 52, intensity_width, 2);
    put_bytes(&file, 54, intensity_height, 2);
    put_bytes(&file, 56, frames, 2);
    put_bytes(&file, 68, columns, 2);
    put_bytes(&file, 70, rows, 2);
    put_bytes(&file, 72, 4 * columns * rows, 4);
    file.replace(80, comment.size(), comment);
    put_float(164, scale);
    put_float(168, wavelength);
    put_float(176, obliquity);
    put_float(184, lateral);
    put_bytes(&file, 218, phase_resolution, 2);
    put_bytes(&file, 232, sign, 2);
    for (std::size_t i = 0; i < intensity; ++i) file[header_bytes + i] = char(0x5a);
    std::size_t at = header_bytes + intensity;
    for (std::uint32_t r = 0; r < rows; ++r)
      for (std::uint32_t c = 0; c < columns; ++c, at += 4)
        put_bytes(&file, at, std::uint32_t(count(r, c)), 4);
    return file;
  }
  /// Surface height of one count, S O W / R [m].
  double unit() const {
    const double counts[] = {4096, 32768, 131072};
    return (sign ? -1.0 : 1.0) * double(scale) * double(obliquity) * double(wavelength) /
           counts[phase_resolution];
  }
};

/// A round part as measured by an interferometer, and its file; `map` is the expected result of a reader.
struct Interferogram {
  HeightMap map;
  MetroProFile file;
};

/// 25 nm of astigmatism, 12 of coma, 8 of spherical aberration, and 400 plane waves with 2-D PSD ~ f^-2.5 and
/// 6 nm RMS from 60 /m to half the Nyquist frequency. The last 5 % are turned down by 300 nm, the edge is
/// ragged with two bites, and dropouts have every invalid code. Heights are rounded to counts.
inline Interferogram made_interferogram(Eigen::Index rows, Eigen::Index columns) {
  Interferogram made;
  MetroProFile& file = made.file;
  file.rows = std::uint32_t(rows), file.columns = std::uint32_t(columns);
  file.intensity_width = 9, file.intensity_height = 7, file.frames = 1;
  file.lateral = 1.18e-4f;
  file.comment = "A part that was never polished";
  HeightMap& map = made.map;
  map.pitch_x = map.pitch_y = double(file.lateral);
  map.x0 = -0.5 * map.pitch_x * double(columns - 1), map.y0 = -0.5 * map.pitch_y * double(rows - 1);
  map.height = Grid::Zero(rows, columns);
  Draws draws(7);
  constexpr int kWaves = 400;
  constexpr double kLow = 60, kRms = 6e-9;
  const double high = 0.25 / map.pitch_x;
  double squares = 0;
  for (int wave = 0; wave < kWaves; ++wave) {
    // With even spacing in log f each wave represents an area f^2 of the frequency plane.
    const double f = kLow * std::pow(high / kLow, (wave + draws.uniform()) / kWaves),
                 angle = 2 * std::numbers::pi * draws.uniform(),
                 phase = 2 * std::numbers::pi * draws.uniform();
    const double amplitude = std::pow(f, 0.5 * (2 - 2.5));
    squares += amplitude * amplitude / 2;
    Eigen::ArrayXcd along(columns), across(rows);
    for (Eigen::Index c = 0; c < columns; ++c)
      along[c] = std::polar(amplitude, 2 * std::numbers::pi * f * std::cos(angle) * map.x(c) + phase);
    for (Eigen::Index r = 0; r < rows; ++r)
      across[r] = std::polar(1.0, 2 * std::numbers::pi * f * std::sin(angle) * map.y(r));
    map.height.matrix() += across.real().matrix() * along.real().matrix().transpose() -
                           across.imag().matrix() * along.imag().matrix().transpose();
  }
  map.height *= kRms / std::sqrt(squares);

  const double radius = 0.5 * map.pitch_x * double(std::min(rows, columns) - 2), unit = file.unit();
  std::vector<std::int32_t> counts(std::size_t(rows * columns));
  std::int32_t code = 2147483640;
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c) {
      const double x = map.x(c) / radius, y = map.y(r) / radius, rho = std::hypot(x, y),
                   theta = std::atan2(y, x);
      double& h = map.height(r, c);
      h += 25e-9 * std::sqrt(6.0) * (x * x - y * y);
      h += 12e-9 * std::sqrt(8.0) * (3 * rho * rho - 2) * y;
      h += 8e-9 * std::sqrt(5.0) * (6 * std::pow(rho, 4) - 6 * rho * rho + 1);
      if (rho > 0.95) h -= 300e-9 * std::pow((rho - 0.95) / 0.05, 2);
      const bool outside = rho > 1 - 0.006 * (1 + std::sin(17 * theta) * std::cos(5 * theta)) ||
                           std::hypot(x - 0.95, y - 0.31) < 0.09 || std::hypot(x + 0.2, y + 1) < 0.07;
      const bool dropout = draws.uniform() < 0.002 || std::hypot(x + 0.4, y - 0.3) < 0.02 ||
                           (std::abs(x - 0.1) < 0.05 && std::abs(y + 0.2) < 1.1 * map.pitch_y / radius);
      std::int32_t& count = counts[std::size_t((rows - 1 - r) * columns + c)];
      count = std::int32_t(std::lround(h / unit));
      h = unit * count;
      if (!outside && !dropout) continue;
      count = code;
      code = code == 2147483647 ? 2147483640 : code + 1;
      h = std::numeric_limits<double>::quiet_NaN();
    }
  file.count = [counts, columns](std::uint32_t row, std::uint32_t column) {
    return counts[std::size_t(row) * std::size_t(columns) + column];
  };
  return made;
}

}  // namespace aberfit::test
