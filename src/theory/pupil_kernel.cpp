#include "pupil_kernel.h"

#define ABERFIT_KERNEL_BODY "../theory/pupil_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void parabola_pairs(InstructionSet set, double per_square, double defocus, const PupilPairs& pairs) {
  ABERFIT_KERNEL(set, wave_pairs)(per_square, defocus, pairs);
}

void add_even_polynomial(InstructionSet set, const double* coefficient, int degree, double scale,
                         const double* x, const double* y, int n, double* result) {
  ABERFIT_KERNEL(set, add_even)(coefficient, degree, scale, x, y, n, result);
}

void chebyshev_moments(InstructionSet set, int order, const double* u, const double* v, const double* weight,
                       int n, double inverse, double* moment) {
  ABERFIT_KERNEL(set, moments_up_to)(order, u, v, weight, n, inverse, moment);
}

}  // namespace aberfit::internal
