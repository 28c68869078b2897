// CODE V interferogram files (.INT) with gridded data. Sources: Gwyddion modules/file/codevfile.c and prysm
// prysm/io.py. Where they differ (order of nx and ny in files that prysm writes) we follow Gwyddion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "aberfit/measured/write_map.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::int64_t kDefaultNoData = 32767;
constexpr double kMetresPerMicrometre = 1e-6;

struct IntHeader {
  std::int64_t columns = 0, rows = 0;
  bool wavefront = false;
  std::optional<double> wavelength;  // [m]
  double counts_per_wave = 0;        // SSZ
  std::int64_t no_data = kDefaultNoData;
  std::optional<double> x_scale;  // XSC: width of the map over its height
};

bool is_grid_header(std::string_view line) {
  const auto word = words(line, kControls);
  return word.size() >= 3 && upper_case(word[0]) == "GRD" && parse_number<std::int64_t>(word[1]) &&
         parse_number<std::int64_t>(word[2]);
}

void require_height_type(const TextLines& lines, const std::string& type) {
  static const std::map<std::string, std::string> others = {{"FIL", "an intensity filter"},
                                                            {"THV", "a variation of coating thickness"},
                                                            {"BIR", "birefringence"},
                                                            {"CAO", "an orientation of crystal axes"}};
  const std::string allowed = "SUR (surface) or WFR (wavefront)";
  if (const auto other = others.find(type); other != others.end())
    lines.fail(type + ", " + other->second + " and no heights", allowed);
  if (type != "SUR" && type != "WFR") lines.fail("type " + in_quotes(type), allowed);
}

// `line` is the last line that was read from `lines`.
IntHeader read_header(const TextLines& lines, std::string_view line) {
  const auto word = words(line, kControls);
  const std::string kind = upper_case(word[0]);
  if (kind == "ZFR" || kind == "ZRN")
    lines.fail(kind + ", a file of Zernike coefficients", "a grid, whose header begins with GRD");
  if (!is_grid_header(line) || word.size() < 4)
    lines.fail(in_quotes(line), "the header GRD nx ny SUR|WFR WVL w SSZ s [NDA n] [XSC x]");
  IntHeader header;
  // The first number is the number of points along x.
  header.columns = *parse_number<std::int64_t>(word[1]);
  header.rows = *parse_number<std::int64_t>(word[2]);
  if (header.columns < 1 || header.rows < 1 || header.columns > kMostMapPoints ||
      header.rows > kMostMapPoints / header.columns)
    lines.fail(fmt::format("a grid of {} x {} points", header.columns, header.rows),
               fmt::format("1 to {} points", kMostMapPoints));
  const std::string type = upper_case(word[3]);
  require_height_type(lines, type);
  header.wavefront = type == "WFR";
  for (std::size_t i = 4; i < word.size(); ++i) {
    const std::string key = upper_case(word[i]);
    if (key == "NNB" || key == "NNR") continue;  // interpolation mode; it does not change the points
    if (key != "WVL" && key != "SSZ" && key != "NDA" && key != "XSC")
      lines.fail(in_quotes(word[i]), "WVL, SSZ, NDA, XSC or NNB");
    const std::string_view text = i + 1 < word.size() ? word[++i] : std::string_view();
    const auto value = parse_finite(text);
    if (key == "NDA") {
      const auto mark = parse_number<std::int64_t>(text);
      if (!mark) lines.fail("NDA " + in_quotes(text), "an integer");
      header.no_data = *mark;
    } else if (!value || *value <= 0) {
      lines.fail(key + " " + in_quotes(text), "a positive number");
    } else if (key == "WVL") {
      header.wavelength = *value * kMetresPerMicrometre;
    } else if (key == "SSZ") {
      header.counts_per_wave = *value;
    } else {
      header.x_scale = *value;
    }
  }
  if (header.counts_per_wave == 0) lines.fail("no SSZ", "SSZ, the counts per wavelength");
  return header;
}

// Returns true for a file without a title. The line after its header then holds only numbers.
bool begins_with_header(const std::string& path) {
  TextLines lines(path);
  std::string_view line;
  if (!next_with_content(&lines, &line) || !is_grid_header(line)) return false;
  return !next_with_content(&lines, &line) || line.find_first_not_of("+-0123456789 \t") == line.npos;
}

// Reads title and header, the first two lines that are neither blank nor comments. The title may be missing.
IntHeader find_header(const std::string& path, TextLines* lines, std::string* label) {
  std::string_view line;
  if (!next_with_content(lines, &line))
    throw InputError(path, "line 1", "no text", "a title and a header GRD nx ny SUR|WFR ...");
  if (!begins_with_header(path)) {
    *label = one_line(line, 80);
    if (!next_with_content(lines, &line))
      lines->fail("the end of the file", "a header GRD nx ny SUR|WFR ...");
  }
  return read_header(*lines, line);
}

}  // namespace

HeightMap read_codev_int(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string& path = source.path;
  TextLines lines(path);
  std::string label;
  const IntHeader header = find_header(path, &lines, &label);
  const std::optional<double> wavelength =
      agreed_length(path, "wavelength", source.wavelength, header.wavelength, kSameWavelength);
  if (!wavelength) throw MissingFact("wavelength", path, "GRD", "no WVL", "WVL [um], or option 'wavelength'");
  // Every value needs a digit and a blank. Checking this first avoids allocating more than the file can hold.
  const std::int64_t points = header.columns * header.rows;
  if (points > std::int64_t(lines.bytes_left() / 2 + 1))
    lines.fail(fmt::format("a grid of {} x {} points before {} bytes of data", header.columns, header.rows,
                           lines.bytes_left()),
               "a file that holds every point");
  const double factor = *wavelength / header.counts_per_wave *
                        surface_per_height(agreed_wavefront(path, source.wavefront, header.wavefront));

  // The file has no length. A given pitch applies to the rows; XSC, if any, gives that of the columns.
  const double pitch_y = source.pitch.value_or(0);
  const double pitch_x =
      header.x_scale ? pitch_y * *header.x_scale * double(header.rows) / double(header.columns) : pitch_y;
  HeightMap map = empty_map(header.rows, header.columns, pitch_x, pitch_y);
  map.label = label;
  std::int64_t point = 0;
  std::string_view line;
  while (next_with_content(&lines, &line))
    for (const std::string_view word : words(line, kControls)) {
      const auto value = parse_number<std::int64_t>(word);
      if (!value) lines.fail(in_quotes(word), "an integer");
      if (point == points)
        lines.fail("a number after the last point",
                   fmt::format("{} x {} numbers", header.columns, header.rows));
      // The file starts with the top row.
      if (*value != header.no_data)
        map.height(header.rows - 1 - point / header.columns, point % header.columns) =
            factor * double(*value);
      ++point;
    }
  if (point < points)
    lines.fail(fmt::format("the end of the file after {} numbers", point),
               fmt::format("{} x {} numbers", header.columns, header.rows));
  return map;
}

std::string codev_int_text(const HeightMap& map, double wavelength, const std::string& title) {
  if (valid_count(map) == 0) throw std::invalid_argument("CODE V INT: the map has no valid point");
  if (!(wavelength > 0 && std::isfinite(wavelength)))
    throw std::invalid_argument("CODE V INT: the wavelength must be positive");
  if (!(map.pitch_x > 0) != !(map.pitch_y > 0))
    throw std::invalid_argument("CODE V INT: the map has one pitch only");
  // 32767 marks missing data, so the largest count is 32766 on both sides of zero. It is assigned to the
  // largest |h|, because a factor from the signed maximum would overflow for a map below zero.
  constexpr double kMostCounts = 32766;
  double largest = 0;
  for (const double h : map.height.reshaped())
    if (std::isfinite(h)) largest = std::max(largest, std::abs(h));
  // The counts use the printed wavelength and scale, so that printing them loses no accuracy.
  const std::string wavelength_text = fmt::format("{:.7g}", wavelength / kMetresPerMicrometre);
  const double printed_wavelength = std::stod(wavelength_text) * kMetresPerMicrometre;
  const std::string scale_text =
      fmt::format("{:.9g}", largest > 0 ? kMostCounts * printed_wavelength / largest : 1.0);
  const double counts_per_metre = std::stod(scale_text) / printed_wavelength;
  if (!std::isfinite(counts_per_metre) || counts_per_metre <= 0 || largest * counts_per_metre > 32766.5)
    throw std::invalid_argument("CODE V INT: heights too small or too large for the format");

  std::string name = one_line(title, 80);
  if (name.empty() || name[0] == '!' || is_grid_header(name))
    name = ("Map " + name).substr(0, 80);  // a reader would take the title for a comment or the header
  std::string header = fmt::format("GRD {} {} SUR WVL {} SSZ {} NDA {}", map.columns(), map.rows(),
                                   wavelength_text, scale_text, kDefaultNoData);
  const double aspect =
      (map.pitch_x > 0 ? map.pitch_x / map.pitch_y : 1) * double(map.columns()) / double(map.rows());
  if (std::abs(aspect - 1) > 1e-12) header += fmt::format(" XSC {:.9g}", aspect);
  constexpr std::size_t kLongestRecord = 80;
  if (header.size() > kLongestRecord)
    throw std::invalid_argument("CODE V INT: the header is longer than a record of 80 characters: " + header);

  std::string text = name + "\r\n" + header + "\r\n";
  text.reserve(text.size() + 8 * std::size_t(map.height.size()));
  for (Eigen::Index row = map.rows() - 1; row >= 0; --row) {
    std::size_t length = 0;
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      const double h = map.height(row, column);
      const std::string count =
          std::to_string(std::isfinite(h) ? std::llround(h * counts_per_metre) : kDefaultNoData);
      if (length > 0 && length + 1 + count.size() > kLongestRecord) {
        text += "\r\n";
        length = 0;
      }
      if (length > 0) text += ' ';
      text += count;
      length += count.size() + (length > 0 ? 1 : 0);
    }
    text += "\r\n";
  }
  return text;
}

}  // namespace aberfit
