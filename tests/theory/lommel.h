#pragma once
#include <cmath>
#include <complex>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"

namespace aberfit::test {

/// Fraction of a perfect mirror's energy inside `ring` [m] in the plane dz [m] from its focus, by Lommel's
/// integral U(u, v) = int_e^1 2 exp(-i u s^2/2) J0(v s) s ds (Born and Wolf 8.8). e is the inner radius of an
/// annulus over the outer one. Paraxial; the image grows with its distance.
inline double light_by_lommel(double aperture_radius, double focal_length, double wavelength, double ring,
                              double dz, double inner = 0) {
  constexpr int kRadial = 60, kZones = 80;
  const double k = 2 * kPi / wavelength, a = aperture_radius, distance = focal_length + dz,
               u = k * a * a * dz / (focal_length * distance);
  const Quadrature radial = gauss_legendre(kRadial, 0.0, k * a * ring / distance),
                   zone = gauss_legendre(kZones, inner, 1.0);
  double sum = 0;
  for (int i = 0; i < kRadial; ++i) {
    std::complex<double> field = 0;
    for (int j = 0; j < kZones; ++j)
      field += zone.weights[j] * zone.nodes[j] * 2.0 * std::cyl_bessel_j(0, radial.nodes[i] * zone.nodes[j]) *
               std::polar(1.0, -0.5 * u * zone.nodes[j] * zone.nodes[j]);
    sum += radial.weights[i] * radial.nodes[i] * std::norm(field) / 2;
  }
  return sum / (1 - inner * inner);
}

}  // namespace aberfit::test
