#pragma once
#include "aberfit/core/instruction_set.h"

/// Vectorised kernels for the points of a pupil's overlap: millions per plane out of focus.
namespace aberfit::internal {

/// n pairs of pupil points P [m], product of amplitudes, difference of phases [rad] (first less second).
struct PupilPairs {
  const double *x1, *y1, *x2, *y2;
  int n;
  double *amplitude, *difference;
};

/// PupilField::pairs for an evenly illuminated parabola: per_square = 1/f^2 [1/m^2], defocus = (2 pi/lambda)
/// dz/(1 + dz/f) [rad].
void parabola_pairs(InstructionSet set, double per_square, double defocus, const PupilPairs& pairs);

/// Adds sum_j coefficient[j] t^j, j <= degree, with t = scale (x^2 + y^2) - 1, at n points to `result`.
void add_even_polynomial(InstructionSet set, const double* coefficient, int degree, double scale,
                         const double* x, const double* y, int n, double* result);

inline constexpr int kHighestMomentOrder = 6;

/// sum_k weight_k T_i(2 a_k - 1) T_j(2 b_k - 1), i major, i and j < order, 1 to kHighestMomentOrder; T
/// Chebyshev polynomials, a = inverse (u^2 + v^2), b = inverse u^2 in [0, 1].
void chebyshev_moments(InstructionSet set, int order, const double* u, const double* v, const double* weight,
                       int n, double inverse, double* moment);

}  // namespace aberfit::internal
