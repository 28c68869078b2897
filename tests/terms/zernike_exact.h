#pragma once
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstdlib>
#include <vector>

#include "aberfit/terms/term_set.h"

/// Zernike modes in 200 decimal digits from the factorial sum of Born & Wolf 9.2.1 (5), without the library's
/// recurrences. The sum cancels 115 digits at n = 300, so more than 80 remain.
namespace zernike_exact {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<200>, boost::multiprecision::et_off>;

/// Radial function of a mode over rho^m: coefficients of (rho^2)^i, i = 0 .. (n - m)/2, orthonormal.
struct Radial {
  int m = 0;
  bool sine = false;
  std::vector<Real> coefficient;
};

inline Real factorial(int n) {
  Real product = 1;
  for (int i = 2; i <= n; ++i) product *= i;
  return product;
}

inline Radial radial(aberfit::ZernikeMode mode) {
  const int n = mode.n, m = std::abs(mode.m), degree = (n - m) / 2;
  const Real norm = sqrt(Real((m == 0 ? 1 : 2) * (n + 1)));
  Radial result{m, mode.m < 0, std::vector<Real>(std::size_t(degree) + 1)};
  for (int s = 0; s <= degree; ++s) {
    const Real term =
        norm * factorial(n - s) / (factorial(s) * factorial((n + m) / 2 - s) * factorial((n - m) / 2 - s));
    result.coefficient[std::size_t(degree - s)] = s % 2 == 0 ? term : -term;
  }
  return result;
}

/// A point given in double precision with its (x + iy)^m, m = 0 .. m_max, with negligible rounding.
struct Point {
  Real x, y, rho_squared;
  std::vector<Real> re, im;

  Point(double px, double py, int m_max)
      : x(px), y(py), rho_squared(x * x + y * y), re{Real(1)}, im{Real(0)} {
    for (int m = 0; m < m_max; ++m) {
      const Real a = re.back(), b = im.back();
      re.push_back(x * a - y * b);
      im.push_back(x * b + y * a);
    }
  }
};

struct Value {
  Real value, dx, dy;
};

inline Value evaluate(const Radial& mode, const Point& at) {
  Real q = 0, dq = 0;  // polynomial in rho^2 and its derivative
  for (std::size_t i = mode.coefficient.size(); i-- > 0;) {
    dq = dq * at.rho_squared + q;
    q = q * at.rho_squared + mode.coefficient[i];
  }
  const std::size_t m = std::size_t(mode.m);
  const Real harmonic = mode.sine ? at.im[m] : at.re[m];
  Real harmonic_dx = 0, harmonic_dy = 0;
  if (m > 0) {
    harmonic_dx = mode.m * (mode.sine ? at.im[m - 1] : at.re[m - 1]);
    harmonic_dy = mode.m * (mode.sine ? at.re[m - 1] : -at.im[m - 1]);
  }
  return {harmonic * q, harmonic_dx * q + 2 * at.x * harmonic * dq,
          harmonic_dy * q + 2 * at.y * harmonic * dq};
}

}  // namespace zernike_exact
