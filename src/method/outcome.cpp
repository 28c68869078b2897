#include "aberfit/method/outcome.h"

#include <cmath>

namespace aberfit {

bool ZoneSlope::more_even() const {
  const double nearest = ratio < draws_low ? draws_low : draws_high;
  return !inside() && std::abs(ratio - 1) < std::abs(nearest - 1);
}

}  // namespace aberfit
