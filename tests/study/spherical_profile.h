#pragma once
#include <array>
#include <cmath>
#include <cstddef>

// Ring-through profile of a rotationally symmetric mirror without the ray tracer. Every ray of height r meets
// the plane z = f + dz at one signed distance x(r) from the axis. So the energy inside a ring is an area: the
// sum of (r_out^2 - r_in^2)/R^2 over the intervals of r with |x(r)| <= ring. Bisection finds the ends of the
// intervals to rounding.
namespace aberfit::test {

/// The mirror of fits/spherical and the planes of its profile.
struct SphericalMirror {
  double focal_length = 2.8;  ///< parabola [m]
  double radius = 0.2;        ///< of the aperture [m]
  std::array<double, 5> rim_height = {0.40e-6, -0.50e-6, 0.30e-6, -0.20e-6,
                                      0.15e-6};  ///< of rho^4 .. rho^12 [m]
  double ring = 15e-6;                           ///< radius [m]
  int half_planes = 20;                          ///< planes dz = -20 .. 20 steps
  double step = 40e-6;                           ///< [m]
};

/// Signed distance [m] from the axis at which the ray of height r meets z = f + dz. If the surface is
/// inclined by a = atan(dz/dr), a ray along -z turns by 2 a, so it moves by tan(2 a) per metre of descent.
inline double axis_distance(const SphericalMirror& mirror, double r, double dz) {
  double height = r * r / (4 * mirror.focal_length), slope = r / (2 * mirror.focal_length);
  for (std::size_t i = 0; i < mirror.rim_height.size(); ++i) {
    const double power = 2.0 * double(i) + 4.0;
    height += mirror.rim_height[i] * std::pow(r / mirror.radius, power);
    slope += mirror.rim_height[i] * power / mirror.radius * std::pow(r / mirror.radius, power - 1);
  }
  return r - (mirror.focal_length + dz - height) * std::tan(2 * std::atan(slope));
}

/// Fraction of the energy inside the ring at z = f + dz. The 4000 steps that find the intervals are enough
/// for the planes of the study: 400,000 steps change no fraction by more than 4e-12.
inline double ring_share(const SphericalMirror& mirror, double dz) {
  constexpr int kSteps = 4000;
  const auto is_inside = [&](double r) { return std::abs(axis_distance(mirror, r, dz)) <= mirror.ring; };
  bool inside = true;  // the vertex ray stays on the axis
  double low = 0, begin = 0, area = 0;
  for (int k = 1; k <= kSteps; ++k) {
    const double high = mirror.radius * k / kSteps;
    if (is_inside(high) != inside) {
      double a = low, b = high;  // the edge lies between them
      for (double middle = 0.5 * (a + b); middle > a && middle < b; middle = 0.5 * (a + b))
        (is_inside(middle) == inside ? a : b) = middle;
      if (inside)
        area += a * a - begin * begin;
      else
        begin = a;
      inside = !inside;
    }
    low = high;
  }
  if (inside) area += mirror.radius * mirror.radius - begin * begin;
  return area / (mirror.radius * mirror.radius);
}

}  // namespace aberfit::test
