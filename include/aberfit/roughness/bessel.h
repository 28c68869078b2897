#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit {

// Bessel functions of many arguments at once, for Hankel transforms. They use the widest instruction set of
// the processor by default; `set` must be supported. Chebyshev series serve below z = 8, series of the Hankel
// amplitudes beyond. Absolute error below 6e-15 + 2e-16 z^(1/2); the second term is the rounding of z.

/// J0(z) and J1(z) of n arguments z >= 0.
void bessel_j0_j1(const double* z, int n, double* j0, double* j1,
                  InstructionSet set = best_instruction_set());
/// sum_i weight_i J1(v s_i) and sum_i weight_i s_i J0(v s_i).
struct BesselSums {
  double first = 0, zeroth = 0;
};
BesselSums bessel_sums(double v, const double* s, const double* weight, int n,
                       InstructionSet set = best_instruction_set());
/// sum_i weight_i (1 - J0(v s_i)), to 1e-13 relative where the weights have one sign.
double one_minus_j0_sum(double v, const double* s, const double* weight, int n,
                        InstructionSet set = best_instruction_set());
/// sqrt(2/(pi z)) (P + iQ), nu = 0 and 1; z >= 8. J_nu(z) is the real part of it times exp(i (z - nu pi/2 -
/// pi/4)).
void hankel_amplitudes(const double* z, int n, double* p0, double* q0, double* p1, double* q1,
                       InstructionSet set = best_instruction_set());
/// sin and cos of n phases [rad]; the absolute error is below 2e-15 + 2e-16 |phase|.
void sin_cos(const double* phase, int n, double* sine, double* cosine,
             InstructionSet set = best_instruction_set());

}  // namespace aberfit
