#pragma once
#include "aberfit/core/instruction_set.h"
#include "fourier_kernel.h"

namespace aberfit::internal {

constexpr int kTileRows = 64;
constexpr int kTileColumns = 256;
constexpr int kRowGroup = 4;      ///< rows that go through a product together
constexpr int kColumnGroup = 16;  ///< columns that do: two vectors of the widest instruction set
constexpr int kModeBlock = 64;    ///< modes whose phases are tabulated at a time

/// Part of a Cartesian grid with its field (forward) or weights (adjoint), small enough for the second-level
/// cache, and the phase tables of one block of modes.
struct GridTile {
  int rows = 0;
  int columns = 0;
  alignas(
      64) double x[kTileColumns];  ///< [m]; places from `columns` on, as those of y from `rows` on, are zero
  alignas(64) double y[kTileRows];
  /// Columns that are wanted per group of rows, from a multiple of kColumnGroup to one; nothing where both
  /// agree.
  int from[kTileRows / kRowGroup];
  int to[kTileRows / kRowGroup];
  alignas(64) double height[kTileRows][kTileColumns];
  alignas(64) double slope_x[kTileRows][kTileColumns];
  alignas(64) double slope_y[kTileRows][kTileColumns];
  alignas(64) double column_phase[kModeBlock * 2 * kTileColumns];
  alignas(64) double row_phase[kModeBlock * 2 * kTileRows];
};

/// Adds sum_k A_k cos(2 pi f_k . x) + B_k sin(2 pi f_k . x) and its gradient at the wanted columns of the
/// tile; `amplitudes` holds A, B per mode. A mode's phase factor is the product of one of its column and one
/// of its row, so a sine and a cosine are needed per mode and row or column only; per mode and point six
/// multiply-adds. Error as in fourier_forward plus one rounding of the product.
void grid_forward(InstructionSet set, const FourierRows& rows, const double* amplitudes, GridTile* tile);

/// Adds to `amplitudes` the weighted sums over the wanted columns: the transpose of grid_forward. Weights in
/// the wanted columns that belong to no point are zero.
void grid_adjoint(InstructionSet set, const FourierRows& rows, GridTile* tile, double* amplitudes);

}  // namespace aberfit::internal
