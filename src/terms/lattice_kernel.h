#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

constexpr int kLatticeTaps = 12;    ///< fine-grid cells along either axis that a point contributes to
constexpr int kLatticeDegree = 15;  ///< degree of the kernel's polynomials between two cells

/// Polynomials of the kernel at its taps, in s from -1 to 1 across a cell, highest power first. Those along x
/// occur twice, for the real and the imaginary part. Those along y are padded to whole vectors.
struct LatticeTable {
  static constexpr int kAlongX = 2 * kLatticeTaps, kAlongY = 16;
  alignas(64) double x[kLatticeDegree + 1][kAlongX];
  alignas(64) double y[kLatticeDegree + 1][kAlongY];
};

/// Position of a point in the fine grid: its first cell, counted in complex numbers, and s along x and y.
struct LatticePlace {
  double x, y;
  long first;
};

/// Adds the complex number at values[2 (g points + p)], times the kernel about point p, to grid[g]. Rows of a
/// grid are `stride` complex numbers apart.
void lattice_spread(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* values, long stride, double* const* grid);

/// The transpose: writes the sums over the cells of kernel times grid[g] to `values`, in the same order.
void lattice_gather(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* const* grid, long stride, double* values);

}  // namespace aberfit::internal
