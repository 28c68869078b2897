#include "aberfit/measured/focal_data.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"
#include "fits_layout.h"
#include "text_columns.h"
#include "text_columns_names.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostColumnsOfCurve = 3;
const char* const kCurveColumns =
    "columns radius (or diameter), share and optionally noise, named with their units in the first row: "
    "\"radius_um, share, noise\"";

// Factors from the columns of a curve to SI units.
struct CurveColumns {
  double radius_factor = 1, share_factor = 1, noise_factor = 1;
  bool is_angle = false;
};

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  for (const char* one : words)
    if (word == one) return true;
  return false;
}

double share_factor(const TextTable& table, const ColumnName& name) {
  if (name.unit.empty() || name.unit == "1") return 1;
  try {
    return unit_factor(name.unit, Dimension::kFraction);
  } catch (const UnitError&) {
    fail_at_line(table.path, 1, "unit " + in_quotes(name.unit) + " of a share", "no unit, or %");
  }
}

CurveColumns curve_columns(const TextTable& table, const std::string& unit) {
  CurveColumns columns;
  ColumnName radius;
  const long line = table.lines.empty() ? 1 : table.lines.front();
  if (table.columns != 2 && table.columns != 3)
    fail_at_line(table.path, line, fmt::format("{} columns", table.columns), kCurveColumns);
  if (!table.names.empty()) {
    radius = column_name(table, 0);
    const ColumnName share = column_name(table, 1);
    if (!is_one_of(radius.word, {"radius", "r", "diameter", "d"}))
      fail_at_line(table.path, line, in_quotes(table.names[0]), kCurveColumns);
    if (!is_one_of(share.word, {"share", "ee", "encircled", "encircled_energy", "encircled energy", "energy",
                                "fraction"}))
      fail_at_line(table.path, line, in_quotes(table.names[1]), kCurveColumns);
    columns.share_factor = share_factor(table, share);
    columns.noise_factor = columns.share_factor;
    if (table.columns == kMostColumnsOfCurve) {
      const ColumnName noise = column_name(table, 2);
      if (!is_one_of(noise.word, {"noise", "sigma", "std", "error", "uncertainty"}))
        fail_at_line(table.path, line, in_quotes(table.names[2]), kCurveColumns);
      if (!noise.unit.empty()) columns.noise_factor = share_factor(table, noise);
    }
  }
  const std::string of_radius = radius.unit.empty() ? unit : radius.unit;
  if (of_radius.empty())
    throw InputError(table.path, "radius", "no unit",
                     "a first row such as \"radius_um, share\", or the unit in the study");
  try {
    columns.radius_factor = unit_factor(of_radius, Dimension::kLength);
  } catch (const UnitError&) {
    try {
      columns.radius_factor = unit_factor(of_radius, Dimension::kAngle);
      columns.is_angle = true;
    } catch (const UnitError&) {
      throw InputError(
          table.path, "radius", "unit " + in_quotes(of_radius),
          allowed_units(Dimension::kLength) + "; on the sky " + allowed_units(Dimension::kAngle));
    }
  }
  if (is_one_of(radius.word, {"diameter", "d"})) columns.radius_factor /= 2;
  return columns;
}

}  // namespace

EncircledCurve read_encircled_curve(const std::string& path, const std::string& unit) {
  // Tolerated excess over 1, for noise and an imperfectly subtracted background.
  constexpr double kOvershoot = 0.2;
  const TextTable table = read_text_table(path, {});
  const CurveColumns columns = curve_columns(table, unit);
  EncircledCurve curve;
  curve.is_angle = columns.is_angle;
  // Many curves begin with (0, 0), which carries no information.
  const std::size_t first = table.rows() > 0 && table(0, 0) == 0 && table(0, 1) == 0 ? 1 : 0;
  const auto count = Eigen::Index(table.rows() - first);
  curve.radius.resize(count);
  curve.share.resize(count);
  curve.noise.resize(table.columns == kMostColumnsOfCurve ? count : 0);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t row = first + std::size_t(k);
    const auto fail = [&](const std::string& found, const std::string& allowed) {
      fail_at_line(path, table.lines[row], found, allowed);
    };
    curve.radius[k] = columns.radius_factor * table(row, 0);
    curve.share[k] = columns.share_factor * table(row, 1);
    if (!(curve.radius[k] > 0)) fail(fmt::format("radius {}", table(row, 0)), "radii above zero");
    if (k > 0 && !(curve.radius[k] > curve.radius[k - 1]))
      fail(fmt::format("radius {} after {}", table(row, 0), table(row - 1, 0)), "increasing radii");
    if (!(std::abs(curve.share[k] - 0.5) <= 0.5 + kOvershoot))
      fail(fmt::format("share {}", table(row, 1)), "energy fractions from 0 to 1, or in %");
    if (curve.noise.size() == 0) continue;
    curve.noise[k] = columns.noise_factor * table(row, 2);
    if (!(curve.noise[k] > 0)) fail(fmt::format("noise {}", table(row, 2)), "standard deviations above zero");
  }
  return curve;
}

FocalImage read_focal_image(const std::string& path) {
  if (detect_format(path) == MeasuredFormat::kFits) return read_fits_image(path);
  const TextTable table = read_text_table(path, {});
  FocalImage image;
  image.light.resize(Eigen::Index(table.rows()), Eigen::Index(table.columns));
  for (std::size_t row = 0; row < table.rows(); ++row)
    for (std::size_t column = 0; column < table.columns; ++column)
      image.light(Eigen::Index(table.rows() - 1 - row), Eigen::Index(column)) = table(row, column);
  return image;
}

bool is_focal_image(const std::string& path) {
  if (detect_format(path) == MeasuredFormat::kFits) return true;
  return read_text_table(path, {}).columns > kMostColumnsOfCurve;
}

}  // namespace aberfit
