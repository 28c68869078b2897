#pragma once
#include "aberfit/measured/profile.h"
#include "text_columns.h"

namespace aberfit::internal {

struct ProfileColumns {
  std::size_t x = 0, value = 1;           ///< columns of the table, from 0
  double x_factor = 1, value_factor = 1;  ///< factors to [m], and to [m] or [rad]
  ProfileQuantity quantity = ProfileQuantity::kHeight;
  /// Step of the rows [m] if the positions in the file are rounded; 0: use the positions of the file.
  double pitch = 0;
};

/// Returns one scan line of a table; descending rows are reversed. Throws InputError with the line for a
/// position that is missing, repeated or out of order, for numbers outside the range of a double in SI units,
/// and for fewer than two values.
/// With a pitch, the positions are the equal steps nearest to the written ones. None may be further off than
/// rounding explains: half a step of the rows or of the written positions, whichever is larger.
Profile profile_of(const TextTable& table, const ProfileColumns& columns);

/// Returns the mean distance of neighbouring rows [m]; requires two rows or more.
double mean_step(const TextTable& table, const ProfileColumns& columns);

}  // namespace aberfit::internal
