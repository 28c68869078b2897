#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"
#include "file_options.h"
#include "matrix_axes.h"
#include "text_columns.h"
#include "text_columns_names.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

// Three columns are points unless the file states otherwise, because no map is three samples wide.
bool holds_points(const TextTable& table) {
  if (const auto layout = key_value(table, "layout")) {
    if (lower_case(*layout) == "matrix") return false;
    if (lower_case(*layout) == "columns" && table.columns == 3) return true;
    fail_at_line(table.path, table.keys.at("layout").line, in_quotes(*layout),
                 "'matrix', or 'columns' for three columns x, y, height");
  }
  return table.columns == 3;
}

double value_factor_of(const MeasuredSource& source, const TextTable& table, const std::string& unit) {
  const std::optional<bool> wavefront = is_wavefront(source, table);
  if (!wavefront)
    throw MissingFact("of", table.path, "",
                      "no statement whether the heights are of the surface or of a wavefront",
                      "the option 'of', or a header line '# of: surface' or '# of: wavefront'");
  const double halve = surface_per_height(*wavefront);
  if (source.value_factor || source.value_in_waves)
    return halve * value_factor_beside(source, table, unit, ProfileQuantity::kHeight);
  if (unit.empty())
    throw MissingFact("value_unit", table.path, "", "heights without unit",
                      "the option 'value_unit', or a header line such as '# unit: nm'");
  return halve * height_factor(unit, source, table, "unit of the heights");
}

double scaled(const TextTable& table, std::size_t row, std::size_t column, double factor) {
  const double value = table(row, column) * factor;
  if (std::isinf(value))
    fail_at_line(table.path, table.lines[row], "a value beyond the range of a double in SI units",
                 "finite numbers");
  return value;
}

// Returns the unit of the heights in the comments; "value units" is Gwyddion's key.
std::string unit_key(const TextTable& table) {
  return key_value(table, "unit").value_or(key_value(table, "value units").value_or(""));
}

// Returns the pitch of one axis [m] from the size of the whole map of `points` samples, which Gwyddion
// writes. The option must agree with it within its printed digits.
double pitch_of_size(const MeasuredSource& source, const TextTable& table, const std::string& key,
                     std::size_t points) {
  const double pitch = *length_key(table, key) / double(points);
  const std::string text = *key_value(table, key);
  const std::string_view digits = std::string_view(text).substr(0, text.find_first_not_of("0123456789."));
  const std::size_t point = digits.find('.');
  const double last =
      point == std::string_view::npos ? 1 : std::pow(10.0, -double(digits.size() - point - 1));
  const double written = parse_finite(digits).value_or(1);
  return *agreed_length(table.path, "pitch", source.pitch, pitch, std::max(kSamePitch, 0.5 * last / written));
}

void set_matrix_pitch(const MeasuredSource& source, const TextTable& table, HeightMap* map) {
  if (table.keys.contains("width") && table.keys.contains("height")) {
    map->pitch_x = pitch_of_size(source, table, "width", table.columns);
    map->pitch_y = pitch_of_size(source, table, "height", table.rows());
    return;
  }
  const std::optional<double> pitch =
      agreed_length(table.path, "pitch", source.pitch, length_key(table, "pitch"), kSamePitch);
  if (!pitch)
    throw MissingFact("pitch", table.path, "", "a matrix of heights without pixel scale",
                      "the option 'pitch', or a header line such as '# pitch = 0.1 mm'");
  map->pitch_x = map->pitch_y = *pitch;
}

HeightMap matrix_map(const MeasuredSource& source, const TextTable& table) {
  if (source.x_factor)
    throw InputError(table.path, "option 'x_unit'", "a unit of positions",
                     "no such option, because a matrix has no positions");
  const std::size_t rows = table.rows(), columns = table.columns;
  if (rows < 2 || columns < 2)
    throw InputError(table.path, "", fmt::format("{} rows and {} columns", rows, columns),
                     "a matrix of at least 2 x 2 heights, or columns x, y, height");
  HeightMap map;
  set_matrix_pitch(source, table, &map);
  const double factor = value_factor_of(source, table, unit_key(table));
  map.file_unit = factor;
  map.height.resize(Eigen::Index(rows), Eigen::Index(columns));
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column)
      map.height(Eigen::Index(source.bottom_first ? row : rows - 1 - row), Eigen::Index(column)) =
          scaled(table, row, column, factor);
  return map;
}

// The regular grid points on which the positions of one axis lie.
struct Axis {
  double first = 0, step = 0;
  double nodes = 0;  // a double, because a bad file may imply more than an integer holds
};

// Positions in a file are rounded: equal within 1e-6 of the range, up to 1/20 step off a grid point.
constexpr double kSamePosition = 1e-6;
constexpr double kOffNode = 0.05;

bool has_axes(const MeasuredSource& source, const TextTable& table) {
  if (source.columns || lower_case(key_value(table, "layout").value_or("")) == "matrix") return false;
  std::vector<std::vector<double>> rows(table.rows(), std::vector<double>(table.columns));
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (std::size_t column = 0; column < table.columns; ++column) rows[row][column] = table(row, column);
  return internal::has_axes(rows);
}

// Returns the heights after these axes as points x, y, height.
TextTable points_of_axes(const TextTable& table) {
  TextTable points = table;
  points.columns = 3;
  points.values.clear(), points.lines.clear(), points.names.clear();
  for (std::size_t row = 1; row < table.rows(); ++row)
    for (std::size_t column = 1; column < table.columns; ++column) {
      points.values.insert(points.values.end(), {table(0, column), table(row, 0), table(row, column)});
      points.lines.push_back(table.lines[row]);
    }
  if (!points.keys.contains("label"))
    points.keys["label"] = {"positions in the first row and column", table.lines.front()};
  return points;
}

Axis axis_of(const TextTable& table, std::size_t column) {
  std::vector<double> positions(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    positions[row] = table(row, column);
    if (std::isnan(positions[row]))
      fail_at_line(table.path, table.lines[row], "a row without position", "numbers x and y");
  }
  std::sort(positions.begin(), positions.end());
  const double range = positions.back() - positions.front();
  const std::string where = column == 0 ? "x" : "y";
  if (!(range > 0) || !std::isfinite(range))
    throw InputError(table.path, "column " + where, range == 0 ? "only one position" : "an infinite range",
                     "points on a regular grid of at least 2 x 2");
  // Rounding spoils single gaps but hardly their mean. The step is therefore the mean of the gaps close to
  // the smallest, then the whole range over the number of steps.
  double smallest = range;
  for (std::size_t i = 1; i < positions.size(); ++i)
    if (const double gap = positions[i] - positions[i - 1]; gap > kSamePosition * range)
      smallest = std::min(smallest, gap);
  double sum = 0, count = 0;
  for (std::size_t i = 1; i < positions.size(); ++i)
    if (const double gap = positions[i] - positions[i - 1];
        gap > kSamePosition * range && gap < (1 + 2 * kOffNode) * smallest) {
      sum += gap;
      ++count;
    }
  const double step = count > 0 ? sum / count : range;
  return {positions.front(), range / std::round(range / step), std::round(range / step) + 1};
}

Eigen::Index node_of(const TextTable& table, std::size_t row, std::size_t column, const Axis& axis) {
  const double node = (table(row, column) - axis.first) / axis.step;
  if (std::abs(node - std::round(node)) > kOffNode)
    fail_at_line(table.path, table.lines[row],
                 fmt::format("{} {:.10g}", column == 0 ? "x" : "y", table(row, column)),
                 fmt::format("points on a regular grid (the others have the step {:.10g})", axis.step));
  return Eigen::Index(std::round(node));
}

// Returns the factor of the positions, from the option, the unit in the column name, or pixel scale over
// step. The file and the option `pitch` must agree.
double position_factor(const MeasuredSource& source, const TextTable& table, std::size_t column,
                       const Axis& axis) {
  const std::string named = column_name(table, column).unit;
  const std::string unit = named.empty() ? key_value(table, "x_unit").value_or("") : named;
  const std::optional<double> pitch =
      agreed_length(table.path, "pitch", source.pitch, length_key(table, "pitch"), kSamePitch);
  if (!source.x_factor && unit.empty()) {
    if (pitch) return *pitch / axis.step;
    throw MissingFact("x_unit", table.path, fmt::format("column {}", column + 1), "positions without unit",
                      "the option 'x_unit' or 'pitch', or a row of names such as 'x_mm, y_mm, height_nm'");
  }
  const double factor =
      source.x_factor ? x_factor_beside(source, table, unit)
                      : factor_or_fail(unit, Dimension::kLength, table, fmt::format("column {}", column + 1));
  if (pitch && std::abs(axis.step * factor / *pitch - 1) > kOffNode)
    throw InputError(table.path, fmt::format("column {}", column + 1),
                     fmt::format("a step of {:.6g} m and a pitch of {:.6g} m", axis.step * factor, *pitch),
                     "a pitch that agrees with the positions, or none");
  return factor;
}

HeightMap point_map(const MeasuredSource& source, const TextTable& table) {
  const Axis x = axis_of(table, 0), y = axis_of(table, 1);
  // A pupil fills most of its grid. An almost empty grid means that the positions lie on no grid.
  constexpr double kLeastFilled = 0.01;
  if (!(double(table.rows()) >= kLeastFilled * x.nodes * y.nodes))
    throw InputError(table.path, "",
                     fmt::format("{} points for a grid of {:g} x {:g}", table.rows(), x.nodes, y.nodes),
                     "points on a regular grid, at least 1 % of it");
  const auto [word, named] = column_name(table, 2);
  if (quantity_of_word(word) == ProfileQuantity::kSlope)
    throw InputError(table.path, "column 3", in_quotes(word), "heights; slopes are read only as profiles");
  const double factor = value_factor_of(source, table, named.empty() ? unit_key(table) : named);
  const double x_factor = position_factor(source, table, 0, x),
               y_factor = position_factor(source, table, 1, y);
  HeightMap map;
  map.x0 = x.first * x_factor;
  map.y0 = y.first * y_factor;
  map.pitch_x = x.step * x_factor;
  map.pitch_y = y.step * y_factor;
  map.file_unit = factor;
  if (!std::isfinite(map.x0 + map.y0 + map.pitch_x * x.nodes + map.pitch_y * y.nodes) ||
      !(map.pitch_x > 0 && map.pitch_y > 0))
    throw InputError(table.path, "", "positions beyond the range of a double in SI units",
                     "finite positions");
  map.height.setConstant(Eigen::Index(y.nodes), Eigen::Index(x.nodes), kHole);
  std::vector<bool> taken(std::size_t(map.height.size()));
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Eigen::Index i = node_of(table, row, 1, y), j = node_of(table, row, 0, x);
    const std::size_t node = std::size_t(i * map.height.cols() + j);
    if (taken[node])
      fail_at_line(table.path, table.lines[row],
                   fmt::format("the point ({:.10g}, {:.10g}) twice", table(row, 0), table(row, 1)),
                   "each point once");
    taken[node] = true;
    map.height(i, j) = scaled(table, row, 2, factor);
  }
  return map;
}

}  // namespace

HeightMap read_map_text(const MeasuredSource& source) {
  check_option(source, source.x_factor, "x_unit", true);
  check_option(source, source.value_factor, "value_unit", false);
  check_option(source, source.pitch, "pitch", true);
  TextRules rules;
  rules.row_length = std::size_t(source.columns.value_or(0));
  TextTable table = read_text_table(source.path, rules);
  const bool axes = has_axes(source, table);
  if (axes) table = points_of_axes(table);
  const bool points = axes || (!source.columns && holds_points(table));
  if (points && source.bottom_first)
    throw InputError(table.path, "option 'first_row'", "points x, y, height",
                     "no such option, because the positions say where a row is");
  HeightMap map = points ? point_map(source, table) : matrix_map(source, table);
  if (!map.height.isFinite().any())
    throw InputError(table.path, "", "no height at all, only holes", "at least one number");
  map.label = key_value(table, "label").value_or(key_value(table, "channel").value_or(""));
  return map;
}

}  // namespace aberfit
