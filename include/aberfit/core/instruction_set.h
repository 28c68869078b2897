#pragma once

/// Kernels are compiled once per instruction set, and the best one of the processor is chosen at run time, so
/// one binary serves every x86-64. Other processors and compilers have kBaseline only.
namespace aberfit {

enum class InstructionSet {
  kBaseline,  ///< the build's own set: SSE2 on x86-64
  kAvx2,      ///< x86-64-v3
  kAvx512,    ///< x86-64-v4
};

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ABERFIT_X86_KERNELS 1
#else
#define ABERFIT_X86_KERNELS 0
#endif

/// The version of `name` for the instruction set `set`. `name` is a function or a table of functions compiled
/// by each_instruction_set.inc; the namespaces of the sets must be visible.
#if ABERFIT_X86_KERNELS
#define ABERFIT_KERNEL(set, name)                             \
  ((set) == ::aberfit::InstructionSet::kAvx512 ? avx512::name \
   : (set) == ::aberfit::InstructionSet::kAvx2 ? avx2::name   \
                                               : baseline::name)
#else
#define ABERFIT_KERNEL(set, name) (static_cast<void>(set), baseline::name)
#endif

/// True if this binary and this processor can run kernels of `set`.
inline bool is_supported([[maybe_unused]] InstructionSet set) {
#if ABERFIT_X86_KERNELS
  if (set == InstructionSet::kAvx512) return __builtin_cpu_supports("x86-64-v4") != 0;
  if (set == InstructionSet::kAvx2) return __builtin_cpu_supports("x86-64-v3") != 0;
#endif
  return set == InstructionSet::kBaseline;
}

/// The usual name of the set: "AVX-512", "AVX2", "baseline".
inline const char* to_string(InstructionSet set) {
  return set == InstructionSet::kAvx512 ? "AVX-512" : set == InstructionSet::kAvx2 ? "AVX2" : "baseline";
}

inline InstructionSet best_instruction_set() {
  if (is_supported(InstructionSet::kAvx512)) return InstructionSet::kAvx512;
  if (is_supported(InstructionSet::kAvx2)) return InstructionSet::kAvx2;
  return InstructionSet::kBaseline;
}

}  // namespace aberfit
