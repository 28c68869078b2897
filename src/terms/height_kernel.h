#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Orbits one kernel call works on, at most; a multiple of 8. With 72 columns their weights take 295 kB,
/// which stays in the second-level cache.
inline constexpr int kBlockOrbits = 128;

/// A run of orbits: points (+-x, +-y) that are mirror images of each other, of which those with x, y >= 0
/// stand for all. `weights`: of functions even in x and y, odd in x, odd in y, odd in both, each orbits x
/// columns, row after row; columns a multiple of 8. Zeros where orbits end.
struct OrbitBlock {
  int orbits = 0;  ///< a multiple of 8
  int columns = 0;
  const double* x = nullptr;
  const double* y = nullptr;
  const double* weights[4] = {};
};

/// sums[2 row + s, column] += sum over orbits of Zernike row (cosine s = 0, sine s = 1) times the weights.
/// Rows and recurrence of zernike_kernel.h, coordinates in units of the radius. basis: 2 longest kBlockOrbits
/// numbers. folded: false where orbits are single points and all weights are those of the first class.
void zernike_heights(InstructionSet set, int m_max, const int* first, const double* recurrence, bool folded,
                     const OrbitBlock& block, double* basis, double* sums);

/// sums[2 mode + s, column] += sum over orbits of cos (s = 0) and sin (s = 1) of 2 pi (fx x + fy y) times the
/// weights; frequency: four numbers per mode, as fourier_kernel.h has them.
void fourier_heights(InstructionSet set, int modes, const double* frequency, bool folded,
                     const OrbitBlock& block, double* basis, double* sums);
inline constexpr int kModesAtOnce = 12;
inline constexpr int kFourierBasis = 4 * kModesAtOnce * kBlockOrbits;  ///< numbers of `basis`

/// sums[row, column] += basis x weights: rows x orbits times orbits x columns of the first class.
void add_height_products(InstructionSet set, int rows, const double* basis, const OrbitBlock& block,
                         double* sums);

}  // namespace aberfit::internal
