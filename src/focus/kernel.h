#pragma once

namespace aberfit {

// Triweight kernel of half-width 1: K(u) = 35/32 (1-u^2)^3 on [-1, 1]. Compact, so that a smooth statistic
// touches only the rays near its radius; three continuous derivatives of its integral, so that Newton steps
// and gradient checks see a smooth function. Second moment 1/9: smoothing a radial density moves a quantile
// by about width^2/18 times its logarithmic slope.

inline double kernel_density(double u) {
  const double v = 1.0 - u * u;
  return v <= 0.0 ? 0.0 : (35.0 / 32.0) * v * v * v;
}

/// Integral of the kernel from -1 to u: 0 below -1, 1 above 1.
inline double kernel_integral(double u) {
  if (u <= -1.0) return 0.0;
  if (u >= 1.0) return 1.0;
  const double u2 = u * u;
  return 0.5 + (35.0 / 32.0) * u * (1.0 - u2 * (1.0 - u2 * (0.6 - u2 / 7.0)));
}

}  // namespace aberfit
