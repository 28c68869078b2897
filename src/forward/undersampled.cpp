#include "undersampled.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/units.h"

namespace aberfit::internal {

std::optional<Warning> undersampled(const TermSet& terms, double pitch) {
  double highest = 0;  // [cycles/m]
  for (const FourierMode& mode : terms.fourier)
    highest = std::max({highest, std::abs(mode.fx), std::abs(mode.fy)});
  for (const ZernikeMode& mode : terms.zernike)
    highest = std::max(highest, zernike_cutoff(mode.n, terms.radius));
  constexpr double kRounding = 1e-9;  // relative, for a pitch from a difference of positions
  if (2 * highest * pitch < 1 - kRounding) return std::nullopt;
  return Warning{"terms-undersampled",
                 fmt::format("terms of up to {} have at most two points per cycle on points {} apart, so "
                             "energy lands in the wrong place; take points {} apart or less, or fewer terms",
                             format_quantity(highest, Dimension::kSpatialFrequency),
                             format_quantity(pitch, Dimension::kLength),
                             format_quantity(1 / (3 * highest), Dimension::kLength))};
}

}  // namespace aberfit::internal
