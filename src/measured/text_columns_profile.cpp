#include "text_columns_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"

namespace aberfit::internal {
namespace {

// Returns how far rounding may move each row from equal steps. If positions are rounded more coarsely than
// the step, some occur twice, and their neighbours are one rounding step away, which grows with the number of
// digits. Without repeated positions, half a step off means a missing row.
template <typename Position>
std::vector<double> rounding_of(const Position& written, std::size_t rows, double step, bool twice) {
  constexpr double kOfDoubles = 1e-9;
  std::vector<double> allowed(rows, 0.5 * std::abs(step) * (twice ? 1 + kOfDoubles : 1 - kOfDoubles));
  const auto allow_gap = [&](std::size_t row, std::size_t other) {
    const double gap = std::abs(written(row) - written(other));
    allowed[row] = std::max(allowed[row], 0.5 * gap * (1 + kOfDoubles));
  };
  if (!twice) return allowed;
  for (std::size_t row = 1, other = 0; row < rows; ++row) {
    if (written(row) != written(row - 1)) other = row - 1;
    allow_gap(row, other);
  }
  for (std::size_t row = rows - 1, other = rows - 1; row-- > 0;) {
    if (written(row) != written(row + 1)) other = row + 1;
    allow_gap(row, other);
  }
  return allowed;
}

// Returns the position of the first row [m] for equal steps; `step` is negative for descending positions.
double first_of_equal_steps(const TextTable& table, const ProfileColumns& columns, double step) {
  const std::size_t rows = table.rows();
  const auto written = [&](std::size_t row) { return table(row, columns.x) * columns.x_factor; };
  const auto off = [&](std::size_t row) { return written(row) - double(row) * step; };
  bool twice = false;
  for (std::size_t row = 0; row < rows; ++row) {
    if (!std::isfinite(written(row)))
      fail_at_line(table.path, table.lines[row], "a row without position", "a number as position");
    twice = twice || (row > 0 && written(row) == written(row - 1));
  }
  const std::vector<double> allowed = rounding_of(written, rows, step, twice);
  std::size_t lowest = 0, highest = 0;  // rows that limit the first position from above and from below
  for (std::size_t row = 0; row < rows; ++row) {
    if (off(row) + allowed[row] < off(lowest) + allowed[lowest]) lowest = row;
    if (off(row) - allowed[row] > off(highest) - allowed[highest]) highest = row;
  }
  const double above = off(lowest) + allowed[lowest], below = off(highest) - allowed[highest];
  const double most = 0.5 * std::abs(off(highest) - off(lowest));
  if (!(below <= above)) {
    const std::size_t row = std::max(lowest, highest);
    fail_at_line(
        table.path, table.lines[row],
        fmt::format("position {:.10g}, {} away from that of equal steps of {}", table(row, columns.x),
                    format_quantity(most, Dimension::kLength),
                    format_quantity(std::abs(step), Dimension::kLength)),
        fmt::format(
            "the step of the rows as option 'pitch' (on average {}), or positions that are not rounded",
            format_quantity(mean_step(table, columns), Dimension::kLength)));
  }
  return 0.5 * (below + above);
}

}  // namespace

double mean_step(const TextTable& table, const ProfileColumns& columns) {
  const std::size_t last = table.rows() - 1;
  return std::abs(table(last, columns.x) - table(0, columns.x)) * columns.x_factor / double(last);
}

Profile profile_of(const TextTable& table, const ProfileColumns& columns) {
  const std::size_t rows = table.rows();
  if (rows < 2)
    throw InputError(table.path, "", fmt::format("{} row of numbers", rows), "at least 2 rows of numbers");
  Profile profile;
  profile.quantity = columns.quantity;
  profile.file_unit = columns.value_factor;
  profile.x.resize(Eigen::Index(rows));
  profile.value.resize(Eigen::Index(rows));
  const bool descending = table(rows - 1, columns.x) < table(0, columns.x);
  const double step = descending ? -columns.pitch : columns.pitch;
  const double first = step == 0 ? 0 : first_of_equal_steps(table, columns, step);
  for (std::size_t row = 0; row < rows; ++row) {
    const double written = table(row, columns.x);
    const double x = step == 0 ? written * columns.x_factor : first + double(row) * step;
    const double value = table(row, columns.value) * columns.value_factor;
    if (std::isnan(written))
      fail_at_line(table.path, table.lines[row], "a row without position", "a number as position");
    if (!std::isfinite(x) || std::isinf(value))
      fail_at_line(table.path, table.lines[row],
                   std::isfinite(x) ? "a value beyond the range of a double in SI units"
                                    : "a position beyond the range of a double in SI units",
                   "finite numbers");
    const Eigen::Index at = Eigen::Index(descending ? rows - 1 - row : row);
    if (row > 0) {
      const double before = profile.x[descending ? at + 1 : at - 1];
      if (x == before)
        fail_at_line(table.path, table.lines[row], fmt::format("position {:.10g} twice", written),
                     fmt::format("each position once; where positions are rounded, their step as option "
                                 "'pitch' (on average {})",
                                 format_quantity(mean_step(table, columns), Dimension::kLength)));
      if ((x < before) != descending)
        fail_at_line(table.path, table.lines[row],
                     fmt::format("position {:.10g} after {:.10g}", written, table(row - 1, columns.x)),
                     descending ? "descending positions, as the first and the last are"
                                : "positions that ascend or descend throughout");
    }
    profile.x[at] = x;
    profile.value[at] = value;
  }
  if (valid_count(profile) < 2)
    throw InputError(table.path, fmt::format("column {}", columns.value + 1),
                     fmt::format("{} numbers", valid_count(profile)), "at least 2 numbers");
  return profile;
}

}  // namespace aberfit::internal
