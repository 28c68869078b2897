#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

constexpr int kLatticeTaps = 12;    ///< cells of the fine grid that a point is spread to along either axis
constexpr int kLatticeDegree = 15;  ///< of the polynomials that are the kernel between two cells

/// Polynomials of the kernel at its taps, in s from -1 to 1 across a cell, highest power first: those along x
/// twice each, one for the real and one for the imaginary part, and those along y padded to whole vectors.
struct LatticeTable {
  static constexpr int kAlongX = 2 * kLatticeTaps, kAlongY = 16;
  alignas(64) double x[kLatticeDegree + 1][kAlongX];
  alignas(64) double y[kLatticeDegree + 1][kAlongY];
};

/// Where a point lies in the fine grid: its first cell, counted in complex numbers, and s along x and y.
struct LatticePlace {
  double x, y;
  long first;
};

/// Adds values[2 (g points + p)] and the number after it, as real and imaginary part, times the kernel about
/// point p to grid[g], whose rows lie `stride` complex numbers apart.
void lattice_spread(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* values, long stride, double* const* grid);

/// Writes to `values`, in the same order, the sums over the cells of kernel times grid[g]: the transpose.
void lattice_gather(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* const* grid, long stride, double* values);

}  // namespace aberfit::internal
