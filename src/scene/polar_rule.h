#pragma once
#include <cstdint>

#include "aberfit/scene/pupil.h"

namespace aberfit::internal {

/// Quadrature between two radii [m]: Gauss-Legendre in rho^2 on `rings` rings, each with `spokes` equal
/// angles. Exact for polynomials of degree <= 4 rings - 2 and < `spokes`.
PupilSample polar_rule(double inner, double outer, std::int64_t rings, std::int64_t spokes);

/// The number nearest to `wanted`, and at least 1, without prime factors above 5. Fourier transforms over the
/// angle take two to five times as long when a large prime divides the number of spokes.
std::int64_t nearest_smooth(std::int64_t wanted);

}  // namespace aberfit::internal
