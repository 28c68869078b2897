#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// Centre and radii in samples from the left and the top.
struct FringeEllipse {
  double x = 0, y = 0, radius_x = 0, radius_y = 0;
  // Any overlap with the square of a sample counts, because programs measure from its middle or its corner.
  bool touches(double column, double row) const {
    const double u = std::max(0.0, std::abs(column - x) - 0.5) / radius_x,
                 v = std::max(0.0, std::abs(row - y) - 0.5) / radius_y;
    return u * u + v * v <= 1;
  }
};

// The notes after the numbers.
struct FringeNotes {
  std::optional<FringeEllipse> outside, obstruction;
  std::optional<double> diameter, wavelength;  // [m]
};

// Reads "ellipse x y rx ry", or "x y r" for a circle.
FringeEllipse fringe_ellipse(const TextLines& lines, const std::vector<std::string_view>& fields) {
  const std::size_t first = fields.size() > 1 && fields[1] == "ellipse" ? 2 : 1;
  std::vector<double> numbers;
  for (std::size_t i = first; i < fields.size(); ++i)
    if (const auto value = parse_finite(fields[i])) numbers.push_back(*value);
  if (numbers.size() == 3) numbers.push_back(numbers.back());
  if (numbers.size() != 4 || numbers.size() < fields.size() - first || !(numbers[2] > 0 && numbers[3] > 0))
    lines.fail(in_quotes(fields.front()) + " without its numbers", "ellipse x y rx ry, or x y r");
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

FringeNotes fringe_notes(TextLines* lines) {
  FringeNotes notes;
  std::string_view line;
  while (lines->next(&line)) {
    const std::vector<std::string_view> fields = words(line);
    if (fields.empty()) continue;
    const auto length = [&](double factor) {
      const auto value = fields.size() > 1 ? parse_finite(fields[1]) : std::nullopt;
      if (!value || !(*value > 0))
        lines->fail(in_quotes(trimmed(line)), "a number above zero after the word");
      return *value * factor;
    };
    if (fields[0] == "outside")
      notes.outside = fringe_ellipse(*lines, fields);
    else if (fields[0] == "obstruction")
      notes.obstruction = fringe_ellipse(*lines, fields);
    else if (fields[0] == "DIAM")
      notes.diameter = length(1e-3);
    else if (fields[0] == "Lambda")
      notes.wavelength = length(1e-9);
    else if (fields[0] != "ROC")
      lines->fail(in_quotes(trimmed(line)),
                  "outside, obstruction, DIAM, ROC or Lambda after the heights (save the wavefront without "
                  "excluded regions)");
  }
  return notes;
}

// The diameter of the mirror corresponds to the ellipse around its samples.
double fringe_pitch(const MeasuredSource& source, const FringeNotes& notes) {
  if (!notes.diameter || !notes.outside) return source.pitch.value_or(0);
  return agreed_pitch(source, *notes.diameter / (2 * notes.outside->radius_x));
}

}  // namespace

HeightMap read_dftfringe(const MeasuredSource& source) {
  require_sane_options(source);
  TextLines lines(source.path);
  std::int64_t size[2] = {0, 0};
  std::string_view line;
  std::vector<std::string_view> fields;
  for (std::int64_t& number : size) {
    if (!lines.next(&line)) lines.fail("the end of the file", "columns and rows in the first two lines");
    const auto value = parse_number<std::int64_t>(trimmed(line));
    if (!value) lines.fail(in_quotes(line), "a whole number: columns, then rows");
    number = *value;
  }
  const auto [columns, rows] = std::pair(size[0], size[1]);
  require_map_size(source.path, "line 1", columns, rows);
  if (std::uint64_t(columns) * std::uint64_t(rows) > lines.bytes_left())
    lines.fail(fmt::format("{} x {} points", columns, rows),
               fmt::format("as many as {} bytes can hold", lines.bytes_left()));
  HeightMap map = empty_map(rows, columns, 0, 0);
  // The heights start with the lowest row. A line may hold several of them.
  for (Eigen::Index point = 0; point < map.height.size();) {
    if (!lines.next(&line)) lines.fail("the end of the file", fmt::format("{} heights", map.height.size()));
    find_words(line, kBlanks, &fields);
    for (const std::string_view field : fields) {
      const std::optional<double> value = parse_number<double>(field);
      if (!value || std::isinf(*value) || point == map.height.size())
        lines.fail(in_quotes(field), "a number for each point of the wavefront");
      map.height(point / columns, point % columns) = *value;
      ++point;
    }
  }
  const FringeNotes notes = fringe_notes(&lines);
  map.pitch_x = map.pitch_y = fringe_pitch(source, notes);
  centre_on_grid(&map);
  const std::optional<double> wavelength =
      agreed_length(source.path, "wavelength", source.wavelength, notes.wavelength, kSameWavelength);
  if (!wavelength)
    throw MissingFact("wavelength", source.path, "Lambda", "heights in waves without a wavelength",
                      "a line 'Lambda 550' after the heights, or option 'wavelength'");
  agreed_wavefront(source.path, source.wavefront, true);
  map.file_unit = *wavelength * surface_per_height(true);
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column) {
      const double from_top = double(rows - 1 - row);
      const bool in_mirror = (!notes.outside || notes.outside->touches(double(column), from_top)) &&
                             !(notes.obstruction && notes.obstruction->touches(double(column), from_top));
      double& height = map.height(row, column);
      // The program writes omitted points as 0.
      height = in_mirror && height != 0 ? height * map.file_unit : std::numeric_limits<double>::quiet_NaN();
    }
  return map;
}

}  // namespace aberfit
