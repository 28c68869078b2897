#pragma once
#include <cstdint>

#include "aberfit/scene/pupil.h"

namespace aberfit::internal {

/// Gauss-Legendre in rho^2 between two radii [m] on `rings` rings of `spokes` equal angles: exact for
/// polynomials of degree 4 rings - 2 and below `spokes`.
PupilSample polar_rule(double inner, double outer, std::int64_t rings, std::int64_t spokes);

/// The number without prime factors beyond 5 that is nearest to `wanted`, at least 1: transforms over the
/// angle take two to five times as long where a large prime divides the number of spokes.
std::int64_t nearest_smooth(std::int64_t wanted);

}  // namespace aberfit::internal
