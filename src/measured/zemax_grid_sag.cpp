// OpticStudio grid sag files (.DAT, .GRD). Source: OpticStudio help, "Grid Sag" surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "aberfit/measured/write_map.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

struct SagHeader {
  std::int64_t columns = 0, rows = 0;
  double step_x = 0, step_y = 0;      // [m]
  double centre_x = 0, centre_y = 0;  // [m]
  double unit = 1;                    // [m]
};

SagHeader read_header(const std::string& path, TextLines* lines) {
  std::string_view line;
  const std::string form = "seven numbers: nx ny delx dely unitflag xdec ydec";
  if (!next_with_content(lines, &line)) throw InputError(path, "line 1", "no text", form);
  const auto word = words(line, kControls);
  if (word.size() != 7) lines->fail(fmt::format("{} in {} words", in_quotes(line), word.size()), form);
  const auto integer = [&](std::size_t i, const char* name) {
    const auto value = parse_number<std::int64_t>(word[i]);
    if (!value) lines->fail(fmt::format("{} {}", name, in_quotes(word[i])), "an integer");
    return *value;
  };
  const auto real = [&](std::size_t i, const char* name) {
    const auto value = parse_finite(word[i]);
    if (!value) lines->fail(fmt::format("{} {}", name, in_quotes(word[i])), "a number");
    return *value;
  };
  SagHeader header;
  header.columns = integer(0, "nx");
  header.rows = integer(1, "ny");
  constexpr std::int64_t kFewest = 5;
  if (header.columns < kFewest || header.rows < kFewest || header.columns > kMostMapPoints ||
      header.rows > kMostMapPoints / header.columns)
    lines->fail(fmt::format("a grid of {} x {} points", header.columns, header.rows),
                fmt::format("at least {0} x {0} and at most {1} points", kFewest, kMostMapPoints));
  constexpr double kMetresPerUnit[] = {1e-3, 1e-2, 25.4e-3, 1};
  const std::int64_t unit = integer(4, "unitflag");
  if (unit < 0 || unit > 3) lines->fail(fmt::format("unitflag {}", unit), "0 (mm), 1 (cm), 2 (in) or 3 (m)");
  header.unit = kMetresPerUnit[unit];
  header.step_x = real(2, "delx") * header.unit;
  header.step_y = real(3, "dely") * header.unit;
  if (!(header.step_x > 0 && header.step_y > 0))
    lines->fail(fmt::format("spacing {} x {}", word[2], word[3]), "positive numbers");
  header.centre_x = real(5, "xdec") * header.unit;
  header.centre_y = real(6, "ydec") * header.unit;
  return header;
}

}  // namespace

GridSag read_zemax_grid_sag_with_derivatives(const std::string& path) {
  TextLines lines(path);
  const SagHeader header = read_header(path, &lines);
  // The shortest line is "0 0 0 0" and its end. The check avoids allocating more than the file can hold.
  const std::int64_t points = header.columns * header.rows;
  if (points > std::int64_t((lines.bytes_left() + 1) / 8))
    lines.fail(fmt::format("a grid of {} x {} points before {} bytes of data", header.columns, header.rows,
                           lines.bytes_left()),
               "a file with a line for every point");
  GridSag sag;
  sag.map = empty_map(header.rows, header.columns, header.step_x, header.step_y);
  sag.map.x0 += header.centre_x;
  sag.map.y0 += header.centre_y;
  sag.dx = sag.dy = sag.dxdy = sag.map.height;
  const std::string form = "z dz/dx dz/dy d2z/dxdy [nodata]";
  std::int64_t point = 0;
  std::string_view line;
  for (; next_with_content(&lines, &line); ++point) {
    if (point == points)
      lines.fail("a line after the last point", fmt::format("{} x {} lines", header.columns, header.rows));
    const auto word = words(line, kControls);
    if (word.size() != 4 && word.size() != 5)
      lines.fail(fmt::format("{} in {} words", in_quotes(line), word.size()), form);
    double value[4];
    for (std::size_t i = 0; i < 4; ++i) {
      const auto read = parse_finite(word[i]);
      if (!read) lines.fail(in_quotes(word[i]), "a number; " + form);
      value[i] = *read;
    }
    const auto no_data =
        word.size() == 5 ? parse_number<std::int64_t>(word[4]) : std::optional<std::int64_t>(0);
    if (!no_data) lines.fail("nodata " + in_quotes(word[4]), "an integer, 0 for valid");
    if (*no_data != 0) continue;
    // Points start at the corner (-x, +y) and run to the right, then downwards.
    const Eigen::Index row = header.rows - 1 - point / header.columns, column = point % header.columns;
    sag.map.height(row, column) = value[0] * header.unit;
    sag.dx(row, column) = value[1];  // slopes have no unit
    sag.dy(row, column) = value[2];
    sag.dxdy(row, column) = value[3] / header.unit;
  }
  if (point < points)
    lines.fail(fmt::format("the end of the file after {} points", point),
               fmt::format("{} x {} lines", header.columns, header.rows));
  return sag;
}

HeightMap read_zemax_grid_sag(const MeasuredSource& source) {
  require_sane_options(source);
  HeightMap map = read_zemax_grid_sag_with_derivatives(source.path).map;
  for (const double pitch : {map.pitch_x, map.pitch_y})
    agreed_length(source.path, "pitch", source.pitch, pitch, kSamePitch);
  // The format stores a sag, which is the surface.
  agreed_wavefront(source.path, source.wavefront, false);
  return map;
}

std::string zemax_grid_sag_text(const GridSag& sag, const std::string& title) {
  const HeightMap& map = sag.map;
  const auto same_shape = [&map](const Grid& grid) {
    return grid.rows() == map.rows() && grid.cols() == map.columns();
  };
  if (!same_shape(sag.dx) || !same_shape(sag.dy) || !same_shape(sag.dxdy))
    throw std::invalid_argument("grid sag: heights and derivatives have different shapes");
  if (map.rows() < 5 || map.columns() < 5)
    throw std::invalid_argument("grid sag: the format wants at least 5 x 5 points");
  if (!(map.pitch_x > 0 && map.pitch_y > 0))
    throw std::invalid_argument("grid sag: the pitch of the map is unknown");
  constexpr double kUnit = 1e-3;  // millimetres, unitflag 0
  std::string text;
  const std::string name = one_line(title, 200);
  if (!name.empty()) text += "! " + name + "\n";
  const double centre_x = map.x(0) + map.pitch_x * double(map.columns() - 1) / 2;
  const double centre_y = map.y(0) + map.pitch_y * double(map.rows() - 1) / 2;
  fmt::format_to(std::back_inserter(text), "{} {} {:.17g} {:.17g} 0 {:.17g} {:.17g}\n", map.columns(),
                 map.rows(), map.pitch_x / kUnit, map.pitch_y / kUnit, centre_x / kUnit, centre_y / kUnit);
  for (Eigen::Index row = map.rows() - 1; row >= 0; --row)
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      const double h = map.height(row, column), dx = sag.dx(row, column), dy = sag.dy(row, column);
      const double dxdy = sag.dxdy(row, column);
      if (!std::isfinite(h)) {
        text += "0 0 0 0 1\n";
        continue;
      }
      if (!std::isfinite(dx) || !std::isfinite(dy) || !std::isfinite(dxdy))
        throw std::invalid_argument("grid sag: a valid height has a derivative that is not finite");
      fmt::format_to(std::back_inserter(text), "{:.12e} {:.12e} {:.12e} {:.12e} 0\n", h / kUnit, dx, dy,
                     dxdy * kUnit);
    }
  return text;
}

}  // namespace aberfit
