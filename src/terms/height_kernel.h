#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Most orbits per kernel call; a multiple of 8. With 72 columns their weights (295 kB) fit the second-level
/// cache.
inline constexpr int kBlockOrbits = 128;

/// A sequence of orbits. An orbit is a set of points (+-x, +-y) that are mirror images; the point with x, y
/// >= 0 represents it. `weights`: four arrays, for functions even in x and y, odd in x, odd in y, odd in
/// both. Each is orbits x columns, row after row; the number of columns is a multiple of 8. Unused orbits are
/// zero.
struct OrbitBlock {
  int orbits = 0;  ///< a multiple of 8
  int columns = 0;
  const double* x = nullptr;
  const double* y = nullptr;
  const double* weights[4] = {};
};

/// sums[2 row + s, column] += sum over orbits of Zernike row (cosine s = 0, sine s = 1) times the weights.
/// Rows and recurrence are those of zernike_kernel.h; coordinates are in units of the radius. basis: 2
/// longest kBlockOrbits numbers. folded: false if orbits are single points; then all weights are in the first
/// class.
void zernike_heights(InstructionSet set, int m_max, const int* first, const double* recurrence, bool folded,
                     const OrbitBlock& block, double* basis, double* sums);

/// sums[2 mode + s, column] += sum over orbits of cos (s = 0) and sin (s = 1) of 2 pi (fx x + fy y) times the
/// weights. frequency: four numbers per mode, as in fourier_kernel.h.
void fourier_heights(InstructionSet set, int modes, const double* frequency, bool folded,
                     const OrbitBlock& block, double* basis, double* sums);
inline constexpr int kModesAtOnce = 12;
inline constexpr int kFourierBasis = 4 * kModesAtOnce * kBlockOrbits;  ///< size of `basis`

/// sums[row, column] += basis x weights: a product of rows x orbits and orbits x columns of the first class.
void add_height_products(InstructionSet set, int rows, const double* basis, const OrbitBlock& block,
                         double* sums);

}  // namespace aberfit::internal
