#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "aberfit/scene/zernike.h"

namespace aberfit {

/// A Zernike term of the mirror that is known beforehand.
struct KnownZernike {
  ZernikeMode mode;
  double height = 0;  ///< surface RMS over the disc [m]; positive towards the incident light
  bool operator==(const KnownZernike&) const = default;
};

/// The nominal mirror: its known shape without roughness. The vertex is at the origin and the mirror opens
/// towards +z, where the light comes from (PHYSICS 1). The known Zernike terms are the only part that is not
/// a surface of revolution. The focus, the planes and the centre of the statistics follow focal_length alone,
/// not the Zernike terms.
struct Mirror {
  double focal_length = 0;              ///< paraxial focal length [m], > 0; vertex radius of curvature 2 f
  double conic = -1;                    ///< conic constant; -1 parabola, 0 sphere
  std::array<double, 5> spherical{};    ///< c4, c6, c8, c10, c12 of sum c_2n rho^2n [m^(1-2n)]
  std::vector<KnownZernike> zernike{};  ///< terms of the design or a measurement, added to the sag
  double zernike_radius = 0;            ///< radius of the disc of the terms [m], > 0 if there are any
  bool operator==(const Mirror&) const = default;
};

/// Returns whether the sag is exactly rho^2/(4f). Only then do rays along the axis have a perfect focus.
bool is_parabola(const Mirror& mirror);
/// Returns whether the sag depends on rho alone: no known Zernike term has m != 0.
bool is_rotationally_symmetric(const Mirror& mirror);
/// The same mirror without its known Zernikes.
Mirror without_known_zernikes(Mirror mirror);

/// Height and slopes of a surface at one point.
template <typename T>
struct SurfacePoint {
  T height;   ///< z [m]
  T slope_x;  ///< dz/dx
  T slope_y;  ///< dz/dy
};

/// Sag and gradient of the nominal mirror at (x, y) [m]: standard conic sag, even powers and known Zernike
/// terms. T: double or a Jet type. Valid for (1+conic) rho^2 < (2f)^2, see `sag_domain_radius`; NaN outside.
/// Beyond their disc the Zernike terms continue as polynomials. trace/nominal_surface.h evaluates the same
/// surface at many points at once.
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
  SurfacePoint<T> point{height, slope_over_rho * x, slope_over_rho * y};
  for (const KnownZernike& term : mirror.zernike) {
    const ZernikePoint<T> z = zernike_at<T>(term.mode, x / mirror.zernike_radius, y / mirror.zernike_radius);
    const double slope = term.height / mirror.zernike_radius;
    point.height = point.height + term.height * z.value;
    point.slope_x = point.slope_x + slope * z.dx;
    point.slope_y = point.slope_y + slope * z.dy;
  }
  return point;
}

/// Largest rho [m] at which the conic sag exists; infinity for conic <= -1.
double sag_domain_radius(const Mirror& mirror);

}  // namespace aberfit
