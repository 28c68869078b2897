#include "lattice_kernel.h"

#define ABERFIT_KERNEL_BODY "../terms/lattice_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

void lattice_spread(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* values, long stride, double* const* grid) {
  ABERFIT_KERNEL(set, spread)(table, points, place, grids, values, stride, grid);
}

void lattice_gather(InstructionSet set, const LatticeTable& table, int points, const LatticePlace* place,
                    int grids, const double* const* grid, long stride, double* values) {
  ABERFIT_KERNEL(set, gather_cells)(table, points, place, grids, grid, stride, values);
}

}  // namespace aberfit::internal
