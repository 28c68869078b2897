#pragma once
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace aberfit {

/// Zernike mode Z_n^m, orthonormal on the unit disc (Noll 1976, unit RMS): m > 0 cosine, m < 0 sine.
struct ZernikeMode {
  int n = 0;
  int m = 0;
  bool operator==(const ZernikeMode&) const = default;
};

/// Value of one mode at one point of the unit disc, and its gradient with respect to the disc coordinates.
template <typename T>
struct ZernikePoint {
  T value{0};
  T dx{0};
  T dy{0};
};
using ZernikeValue = ZernikePoint<double>;

/// True for n >= 0, |m| <= n, n - |m| even.
bool is_zernike_mode(ZernikeMode mode);

/// Throws std::invalid_argument unless is_zernike_mode(mode).
void require_zernike_mode(ZernikeMode mode);

/// Frequency [cycles/m] up to which all modes of orders <= n on a disc of `radius` [m] represent a surface:
/// (n + 1)/(2 pi radius). There the transform of order n, J_{n+1}(2 pi radius f)/f, changes from a power of f
/// to an oscillation.
inline double zernike_cutoff(int n, double radius) { return (n + 1) / (2 * std::numbers::pi * radius); }

/// Factor that makes the peak-normalised mode (R_n^m(1) = 1) orthonormal on the disc: sqrt(n + 1), times
/// sqrt(2) unless m = 0 (Noll 1976, eq. 1). A Fringe coefficient is the orthonormal coefficient times this.
double zernike_norm(ZernikeMode mode);

/// Z_n^m and its gradient at (x, y), for rho^2 = x^2 + y^2 <= 1 or slightly above. SurfaceOperator (terms)
/// evaluates many modes at once. T: double or a Jet type. Z = norm Re or Im (x + iy)^|m| P_k^(0,|m|)(2 rho^2
/// - 1), k = (n - |m|) / 2. The Jacobi polynomial and its derivative come from the three-term recurrence
/// (DLMF 18.9.2). There are no factorials, no angles and no division by rho, so the vertex is an ordinary
/// point. Error, relative to the largest value (largest gradient) of the mode over the disc: below 1e-12 for
/// n <= 100, 1e-11 for n <= 300. Throws std::invalid_argument unless is_zernike_mode(mode).
template <typename T>
ZernikePoint<T> zernike_at(ZernikeMode mode, const T& x, const T& y) {
  require_zernike_mode(mode);
  const int m = std::abs(mode.m), degree = (mode.n - m) / 2;

  // P_k^(0,m)(t) and its derivative with respect to t, by a recurrence upwards in the degree.
  const T t = 2.0 * (x * x + y * y) - 1.0;
  T p{1.0}, p_before{0.0}, dp{0.0}, dp_before{0.0};
  for (int k = 0; k < degree; ++k) {
    const double s = 2.0 * k + m;
    const double denominator = 2.0 * (k + 1.0) * (k + m + 1.0);
    const double a = (s + 1.0) * (s + 2.0) / denominator;
    const double b = m == 0 ? 0.0 : -double(m) * m * (s + 1.0) / (denominator * s);
    const double c = k == 0 ? 0.0 : 2.0 * k * (k + m) * (s + 2.0) / (denominator * s);
    const T p_next = (a * t + b) * p - c * p_before;
    const T dp_next = (a * t + b) * dp + a * p - c * dp_before;
    p_before = p, p = p_next;
    dp_before = dp, dp = dp_next;
  }

  // (x + iy)^m is the harmonic; m (x + iy)^(m-1) gives its gradient.
  T re{1.0}, im{0.0}, d_re{0.0}, d_im{0.0};
  for (int i = 0; i < m; ++i) {
    d_re = double(m) * re, d_im = double(m) * im;
    const T re_next = x * re - y * im;
    im = y * re + x * im;
    re = re_next;
  }
  const bool sine = mode.m < 0;
  const T harmonic = sine ? im : re, harmonic_dx = sine ? d_im : d_re, harmonic_dy = sine ? d_re : T(-d_im);
  const double norm = zernike_norm(mode);
  return {norm * harmonic * p, norm * (harmonic_dx * p + 4.0 * x * harmonic * dp),
          norm * (harmonic_dy * p + 4.0 * y * harmonic * dp)};
}

/// The same in double precision, compiled once.
ZernikeValue zernike(ZernikeMode mode, double x, double y);

/// Noll's single index, from 1: (0,0) (1,1) (1,-1) (2,0) (2,-2) (2,2) ...; even j are cosines (Noll 1976,
/// table 1). It is also the index of `Zernike Standard` in OpticStudio. All index functions below throw
/// std::invalid_argument for an index below the first one and for an invalid mode.
int noll_index(ZernikeMode mode);
ZernikeMode zernike_from_noll(int j);

/// OSA/ANSI Z80.28 single index, from 0: j = (n (n + 2) + m) / 2.
int osa_index(ZernikeMode mode);
ZernikeMode zernike_from_osa(int j);

/// Fringe (University of Arizona) single index, from 1: j = (1 + (n + |m|)/2)^2 - 2 |m| + [m < 0]. Fringe
/// terms are peak-normalised (R = 1 at the rim), see zernike_norm.
int fringe_index(ZernikeMode mode);
ZernikeMode zernike_from_fringe(int j);

}  // namespace aberfit
