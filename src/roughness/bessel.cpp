#include "aberfit/roughness/bessel.h"

#define ABERFIT_KERNEL_BODY "../roughness/bessel_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit {
using namespace internal;

void bessel_j0_j1(const double* z, int n, double* j0, double* j1, InstructionSet set) {
  return ABERFIT_KERNEL(set, all_j0_j1)(z, n, j0, j1);
}

BesselSums bessel_sums(double v, const double* s, const double* weight, int n, InstructionSet set) {
  BesselSums result;
  ABERFIT_KERNEL(set, sums)(v, s, weight, n, &result.first, &result.zeroth);
  return result;
}

double one_minus_j0_sum(double v, const double* s, const double* weight, int n, InstructionSet set) {
  return ABERFIT_KERNEL(set, one_minus_sum)(v, s, weight, n);
}

void hankel_amplitudes(const double* z, int n, double* p0, double* q0, double* p1, double* q1,
                       InstructionSet set) {
  return ABERFIT_KERNEL(set, all_amplitudes)(z, n, p0, q0, p1, q1);
}

void sin_cos(const double* phase, int n, double* sine, double* cosine, InstructionSet set) {
  return ABERFIT_KERNEL(set, all_sin_cos)(phase, n, sine, cosine);
}

}  // namespace aberfit
