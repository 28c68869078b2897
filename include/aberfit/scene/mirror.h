#pragma once
#include <array>
#include <cmath>

namespace aberfit {

/// Rotationally symmetric mirror, vertex at the origin, opening towards +z where the light comes from
/// (PHYSICS 1).
struct Mirror {
  double focal_length = 0;            ///< paraxial focal length [m], > 0; vertex radius of curvature 2 f
  double conic = -1;                  ///< conic constant; -1 parabola, 0 sphere
  std::array<double, 5> spherical{};  ///< c4, c6, c8, c10, c12 of sum c_2n rho^2n [m^(1-2n)]
};

/// Height and slopes of a surface at one point.
template <typename T>
struct SurfacePoint {
  T height;   ///< z [m]
  T slope_x;  ///< dz/dx
  T slope_y;  ///< dz/dy
};

/// Sag and gradient of the mirror without roughness at (x, y) [m]: standard conic sag plus even powers.
/// Valid for (1+conic) rho^2 < (2f)^2, see `sag_domain_radius`; NaN outside. Scalars: double or a Jet type.
template <typename T>
SurfacePoint<T> base_surface(const Mirror& mirror, const T& x, const T& y) {
  using std::sqrt;
  const double curvature = 1.0 / (2.0 * mirror.focal_length);
  const T rho2 = x * x + y * y;
  const T root = sqrt(1.0 - (1.0 + mirror.conic) * curvature * curvature * rho2);
  T height = curvature * rho2 / (1.0 + root);
  T slope_over_rho = curvature / root;
  T power = rho2;  // rho^(2n-2)
  for (int i = 0; i < 5; ++i) {
    slope_over_rho = slope_over_rho + (2.0 * (i + 2)) * mirror.spherical[i] * power;
    power = power * rho2;
    height = height + mirror.spherical[i] * power;
  }
  return {height, slope_over_rho * x, slope_over_rho * y};
}

/// Largest rho [m] at which the conic sag exists; infinity for conic <= -1.
double sag_domain_radius(const Mirror& mirror);

}  // namespace aberfit
