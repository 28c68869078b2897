#include "text_columns_profile.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/errors.h"

namespace aberfit::internal {

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
  for (std::size_t row = 0; row < rows; ++row) {
    const double written = table(row, columns.x);
    const double x = written * columns.x_factor, value = table(row, columns.value) * columns.value_factor;
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
                     "each position once");
      if ((x < before) != descending)
        fail_at_line(table.path, table.lines[row],
                     fmt::format("position {:.10g} after {:.10g}", written, table(row - 1, columns.x)),
                     descending ? "positions that descend as the first and the last do"
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
