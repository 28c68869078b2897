#include "aberfit/roughness/bessel.h"

#define ABERFIT_KERNEL_BODY "../roughness/bessel_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"
#undef ABERFIT_KERNEL_BODY

namespace aberfit {
using namespace internal;

void bessel_j0_j1(const double* z, int n, double* j0, double* j1, InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::all_j0_j1(z, n, j0, j1);
  if (set == InstructionSet::kAvx2) return avx2::all_j0_j1(z, n, j0, j1);
#endif
  static_cast<void>(set);
  return baseline::all_j0_j1(z, n, j0, j1);
}

void one_minus_j0(const double* z, int n, double* result, InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::all_one_minus_j0(z, n, result);
  if (set == InstructionSet::kAvx2) return avx2::all_one_minus_j0(z, n, result);
#endif
  static_cast<void>(set);
  return baseline::all_one_minus_j0(z, n, result);
}

namespace {
void sums(InstructionSet set, double v, const double* s, const double* weight, int n, BesselSums* result) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::sums(v, s, weight, n, &result->first, &result->zeroth);
  if (set == InstructionSet::kAvx2) return avx2::sums(v, s, weight, n, &result->first, &result->zeroth);
#endif
  static_cast<void>(set);
  return baseline::sums(v, s, weight, n, &result->first, &result->zeroth);
}
}  // namespace

BesselSums bessel_sums(double v, const double* s, const double* weight, int n, InstructionSet set) {
  BesselSums result;
  sums(set, v, s, weight, n, &result);
  return result;
}

double one_minus_j0_sum(double v, const double* s, const double* weight, int n, InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::one_minus_sum(v, s, weight, n);
  if (set == InstructionSet::kAvx2) return avx2::one_minus_sum(v, s, weight, n);
#endif
  static_cast<void>(set);
  return baseline::one_minus_sum(v, s, weight, n);
}

void hankel_amplitudes(const double* z, int n, double* p0, double* q0, double* p1, double* q1,
                       InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::all_amplitudes(z, n, p0, q0, p1, q1);
  if (set == InstructionSet::kAvx2) return avx2::all_amplitudes(z, n, p0, q0, p1, q1);
#endif
  static_cast<void>(set);
  return baseline::all_amplitudes(z, n, p0, q0, p1, q1);
}

void sin_cos(const double* phase, int n, double* sine, double* cosine, InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return avx512::all_sin_cos(phase, n, sine, cosine);
  if (set == InstructionSet::kAvx2) return avx2::all_sin_cos(phase, n, sine, cosine);
#endif
  static_cast<void>(set);
  return baseline::all_sin_cos(phase, n, sine, cosine);
}

}  // namespace aberfit
