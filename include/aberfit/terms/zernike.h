#pragma once
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Value and gradient of one mode at one point of the unit disc; the gradient is with respect to the disc
/// coordinates.
struct ZernikeValue {
  double value = 0;
  double dx = 0;
  double dy = 0;
};

/// True for n >= 0, |m| <= n, n - |m| even.
bool is_zernike_mode(ZernikeMode mode);

/// Factor that makes the peak-normalised mode (R_n^m(1) = 1) orthonormal on the disc: sqrt(n + 1), times
/// sqrt(2) unless m = 0 (Noll 1976, eq. 1). A Fringe coefficient is the orthonormal coefficient times this.
double zernike_norm(ZernikeMode mode);

/// Z_n^m and its gradient at (x, y), rho^2 = x^2 + y^2 <= 1 (or slightly above), one mode at a time: the
/// plain twin of SurfaceOperator. Z = norm Re or Im (x + iy)^|m| P_k^(0,|m|)(2 rho^2 - 1), k = (n - |m|) / 2,
/// with the Jacobi polynomial and its derivative from the three-term recurrence (DLMF 18.9.2): no factorials,
/// no angle and no division by rho, so the vertex is an ordinary point. Error, relative to the largest value
/// (largest gradient) of the mode over the disc: below 1e-12 for n <= 100, 1e-11 for n <= 300. Throws
/// std::invalid_argument unless is_zernike_mode(mode).
ZernikeValue zernike(ZernikeMode mode, double x, double y);

/// Noll's single index, from 1: (0,0) (1,1) (1,-1) (2,0) (2,-2) (2,2) ...; even j are cosines (Noll 1976,
/// table 1). Also OpticStudio's `Zernike Standard`. The functions with an index throw std::invalid_argument
/// when it is below the first one, those with a mode unless is_zernike_mode(mode).
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
