#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "instrument_text.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// The lines before the first '#', identified by position only and counted from 1, as in messages.
class ZygoHeader {
 public:
  explicit ZygoHeader(const std::string& path, TextLines* lines) : path_(path) {
    constexpr std::size_t kMost = 40;
    std::string_view line;
    while (lines->next(&line)) {
      if (trimmed(line) == "#") return;
      if (lines_.size() == kMost) break;
      lines_.emplace_back(trimmed(line));
    }
    throw InputError(path, "", fmt::format("{} lines without '#'", lines_.size()),
                     "the header of MetroPro, which a line '#' ends");
  }

  const std::string& line(std::size_t number) const {
    if (number > lines_.size())
      throw InputError(path_, "", fmt::format("a header of {} lines", lines_.size()),
                       fmt::format("{} lines or more before '#'", number));
    return lines_[number - 1];
  }
  // Returns a field of a line; both count from 1.
  double number(std::size_t line_number, std::size_t field, const char* what) const {
    const std::vector<std::string_view> fields = words(line(line_number));
    const std::optional<double> value =
        field <= fields.size() ? parse_finite(fields[field - 1]) : std::nullopt;
    if (!value)
      fail_at_line(path_, long(line_number),
                   field <= fields.size() ? in_quotes(fields[field - 1]) : "too few numbers",
                   fmt::format("{} as number {} of the line", what, field));
    return *value;
  }
  std::int64_t count(std::size_t line_number, std::size_t field, const char* what) const {
    const double value = number(line_number, field, what);
    if (!(value >= 0 && value <= 1e9 && value == std::floor(value)))
      fail_at_line(path_, long(line_number), fmt::format("{} {:g}", what, value), "a whole number");
    return std::int64_t(value);
  }
  // Returns the wavelength [m] of line 8 if it is plausible. The option must agree with it.
  double wavelength(const MeasuredSource& source) const {
    constexpr double kShortest = 1e-9, kLongest = 1e-3;
    const double said = number(8, 3, "the wavelength [m]");
    const bool sane = said >= kShortest && said <= kLongest;
    if (!sane && !source.wavelength)
      throw MissingFact("wavelength", path_, "line 8", fmt::format("wavelength {:g} m", said),
                        "1e-9 to 1e-3 m, or option 'wavelength'");
    return *agreed_length(path_, "wavelength", source.wavelength, sane ? std::optional(said) : std::nullopt,
                          kSameWavelength);
  }

 private:
  const std::string& path_;
  std::vector<std::string> lines_;
};

struct ZygoPoint {
  double x = 0, y = 0, height = 0;
};

// Reads lines "x y height" or "x y No Data" up to '#'.
std::vector<ZygoPoint> zygo_points(TextLines* lines, double factor) {
  std::vector<ZygoPoint> points;
  std::string_view line;
  std::vector<std::string_view> fields;
  while (lines->next(&line)) {
    find_words(line, kBlanks, &fields);
    if (fields.empty()) continue;
    if (fields.front() == "#") return points;
    const std::optional<double> x = parse_finite(fields[0]),
                                y = fields.size() > 1 ? parse_finite(fields[1]) : std::nullopt;
    const bool hole = fields.size() == 4 && fields[2] == "No" && fields[3] == "Data";
    const std::optional<double> z = fields.size() == 3 ? parse_finite(fields[2]) : std::nullopt;
    if (!x || !y || !(hole || z))
      lines->fail(in_quotes(trimmed(line)), "column, row and height, or 'No Data' as height");
    points.push_back({*x, *y, hole ? std::numeric_limits<double>::quiet_NaN() : factor * *z});
  }
  lines->fail("the end of the file", "'#' after the last point");
}

// Positions count camera samples, or map samples if the corner of the map is not included in them.
void place_points(const std::string& path, const std::vector<ZygoPoint>& points, double first_x,
                  double first_y, HeightMap* map) {
  const auto fits = [&](double x0, double y0) {
    return std::all_of(points.begin(), points.end(), [&](const ZygoPoint& point) {
      return point.x >= x0 && point.y >= y0 && point.x < x0 + double(map->columns()) &&
             point.y < y0 + double(map->rows()) && point.x == std::floor(point.x) &&
             point.y == std::floor(point.y);
    });
  };
  if (!fits(first_x, first_y)) {
    if (!fits(0, 0))
      throw InputError(
          path, "", "positions outside the map",
          fmt::format("whole numbers inside {} x {} samples, as line 4 says", map->columns(), map->rows()));
    first_x = first_y = 0;
  }
  for (const ZygoPoint& point : points)
    map->height(map->rows() - 1 - Eigen::Index(point.y - first_y), Eigen::Index(point.x - first_x)) =
        point.height;
}

// Reads blocks of whole numbers, each ended by '#'.
std::vector<std::vector<std::int64_t>> zygo_blocks(TextLines* lines) {
  std::vector<std::vector<std::int64_t>> blocks(1);
  std::string_view line;
  std::vector<std::string_view> fields;
  while (lines->next(&line)) {
    find_words(line, kBlanks, &fields);
    for (const std::string_view field : fields) {
      if (field == "#") {
        if (!blocks.back().empty()) blocks.emplace_back();
        continue;
      }
      const std::optional<std::int64_t> value = parse_number<std::int64_t>(field);
      if (!value) lines->fail(in_quotes(field), "a whole number, or '#' at the end of a block");
      blocks.back().push_back(*value);
    }
  }
  if (blocks.back().empty()) blocks.pop_back();
  return blocks;
}

// Returns the height of one count [m], S O W / R as in the binary file (zygo.cpp).
double zygo_count(const ZygoHeader& header, const MeasuredSource& source) {
  const double scale = header.number(8, 2, "the interferometric scale factor"),
               obliquity = header.number(8, 5, "the obliquity factor");
  if (scale == 0 || obliquity == 0)
    fail_at_line(source.path, 8, fmt::format("scale factor {:g}, obliquity factor {:g}", scale, obliquity),
                 "numbers other than 0, often 0.5 and 1");
  constexpr double kCountsPerWave[] = {4096, 32768, 131072};
  const std::int64_t resolution = header.count(11, 1, "the phase resolution");
  if (resolution > 2)
    fail_at_line(source.path, 11, fmt::format("phase resolution {}", resolution), "0, 1 or 2");
  const bool inverted = header.number(11, 8, "the sign of the data") != 0;
  return scale * obliquity * header.wavelength(source) / kCountsPerWave[resolution] * (inverted ? -1 : 1);
}

// Counts from this value on mean no data.
constexpr std::int64_t kNoZygoCount = 2147483640;

void place_counts(const std::string& path, const std::vector<std::vector<std::int64_t>>& blocks, double count,
                  HeightMap* map) {
  // Intensity frames precede the phase.
  const std::size_t wanted = std::size_t(map->height.size()),
                    there = blocks.empty() ? 0 : blocks.back().size();
  if (there != wanted)
    throw InputError(path, "", fmt::format("{} phases in the last block", there),
                     fmt::format("{} x {}, as line 4 says", map->columns(), map->rows()));
  for (std::size_t i = 0; i < wanted; ++i)
    if (const std::int64_t value = blocks.back()[i]; value < kNoZygoCount)
      map->height(map->rows() - 1 - Eigen::Index(i) / map->columns(), Eigen::Index(i) % map->columns()) =
          count * double(value);
}

}  // namespace

HeightMap read_zygo_text(const MeasuredSource& source) {
  require_sane_options(source);
  TextLines lines(source.path);
  const ZygoHeader header(source.path, &lines);
  const bool xyz = header.line(1).starts_with(kZygoXyzTitle);
  if (!xyz && !header.line(1).starts_with(kZygoAsciiTitle))
    fail_at_line(source.path, 1, in_quotes(header.line(1)),
                 fmt::format("'{}' or '{}'", kZygoXyzTitle, kZygoAsciiTitle));
  const std::int64_t columns = header.count(4, 3, "the width of the phase"),
                     rows = header.count(4, 4, "its height");
  // A point needs at least two bytes.
  require_map_size(source.path, "line 4", columns, rows);
  if (std::uint64_t(columns) * std::uint64_t(rows) > lines.bytes_left() / 2)
    fail_at_line(source.path, 4, fmt::format("{} x {} points", columns, rows),
                 fmt::format("as many as {} bytes after the header can hold", lines.bytes_left()));
  // With the scale factor the heights are those of the surface.
  agreed_wavefront(source.path, source.wavefront, false);
  const double pitch = agreed_pitch(source, header.number(8, 7, "the pitch [m]"));
  HeightMap map = empty_map(rows, columns, pitch, pitch);
  std::string comment = header.line(5);
  std::erase(comment, '"');
  map.label = one_line(comment, 82);
  if (xyz) {
    // MetroPro writes micrometres. Later programs let the user choose; the option then gives the unit.
    const double factor =
        source.value_in_waves ? header.wavelength(source) : source.value_factor.value_or(1e-6);
    map.file_unit = factor;
    place_points(source.path, zygo_points(&lines, factor), header.number(4, 1, "the first column"),
                 header.number(4, 2, "the first row"), &map);
  } else {
    if (source.value_factor || source.value_in_waves)
      throw InputError(source.path, "option 'value_unit'", "counts of the phase",
                       "no such option, because such files state what their heights are");
    map.file_unit = zygo_count(header, source);
    place_counts(source.path, zygo_blocks(&lines), map.file_unit, &map);
  }
  return map;
}

}  // namespace aberfit
