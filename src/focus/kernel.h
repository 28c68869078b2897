#pragma once

namespace aberfit::internal {

// Triweight kernel of half-width 1: K(u) = 35/32 (1-u^2)^3 on [-1, 1]. It is compact, so a smooth statistic
// uses only the rays near its radius. Its integral has three continuous derivatives, which Newton steps and
// gradient checks need. The second moment is 1/9. Smoothing a radial density moves a quantile by about
// width^2/18 times its logarithmic slope.

/// Integral of the kernel from -1 to u: 0 below -1, 1 above 1.
inline double kernel_integral(double u) {
  if (u <= -1.0) return 0.0;
  if (u >= 1.0) return 1.0;
  const double u2 = u * u;
  return 0.5 + (35.0 / 32.0) * u * (1.0 - u2 * (1.0 - u2 * (0.6 - u2 / 7.0)));
}

/// Smooth version of the test "inside `radius`", as a function of the squared distance r^2 of a ray. It is
/// the kernel integral of (radius^2 - r^2)/(2 radius width), which approaches (radius - r)/width for width <<
/// radius. It is smooth at the centre and falls to 0 with the radius.
struct SmoothDisc {
  double radius, radius2, scale;  // scale = 1 / (2 radius width)
  double inside2, outside2;       // every ray counts within inside2; none beyond outside2
  SmoothDisc(double r, double width)
      : radius(r),
        radius2(r * r),
        scale(0.5 / (r * width)),
        inside2(r * r - 2 * r * width),
        outside2(r * r + 2 * r * width) {}

  double share(double r2) const { return kernel_integral((radius2 - r2) * scale); }
};

/// If the spot is smaller than this many kernel widths, the derivative of its radius has no meaning.
inline constexpr double kSmallestSpotInWidths = 1e-3;

}  // namespace aberfit::internal
