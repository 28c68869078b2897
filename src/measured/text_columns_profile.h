#pragma once
#include "aberfit/measured/profile.h"
#include "text_columns.h"

namespace aberfit::internal {

struct ProfileColumns {
  std::size_t x = 0, value = 1;           ///< columns of the table, from 0
  double x_factor = 1, value_factor = 1;  ///< to [m] and to [m] or [rad]
  ProfileQuantity quantity = ProfileQuantity::kHeight;
  /// Step of the rows [m] where the positions in the file are rounded; 0: the positions say it.
  double pitch = 0;
};

/// One scan line of a table. Rows that descend are turned round. Throws InputError, with the line, for a
/// position that is missing, twice there or out of order, for numbers that leave the range of a double in SI,
/// and for fewer than two values. With a pitch the positions are those of equal steps which lie nearest to
/// what is written, and none may be further off than rounding explains: half a step, of the rows or of the
/// written positions, whichever is larger.
Profile profile_of(const TextTable& table, const ProfileColumns& columns);

/// Mean distance of neighbouring rows [m]; there must be two rows or more.
double mean_step(const TextTable& table, const ProfileColumns& columns);

}  // namespace aberfit::internal
