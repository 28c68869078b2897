#pragma once
#include "aberfit/core/instruction_set.h"
#include "zernike_kernel.h"

namespace aberfit::internal {

/// Rings per kernel call: two vectors of the widest instruction set.
constexpr int kBlockRings = 16;

/// First points z = x + iy = rho e^(i turn) of the rings of a block, in units of the radius; unused: zero.
struct RingBlock {
  alignas(64) double x[kBlockRings];
  alignas(64) double y[kBlockRings];
};

/// Data of the rings of a block at one azimuthal order m (zernike_polar.h), real and imaginary part per ring.
struct RingOrder {
  alignas(64) double height_re[kBlockRings], height_im[kBlockRings];
  alignas(64) double up_re[kBlockRings], up_im[kBlockRings];
  alignas(64) double down_re[kBlockRings], down_im[kBlockRings];
};

/// Amplitudes of the rings, orders[0 .. m_max], from the packed row coefficients (see zernike_forward).
/// Slopes are multiplied by `slope_unit`.
void polar_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, double slope_unit,
                   const RingBlock& rings, RingOrder* orders);

/// The transpose: adds to `packed` what orders[0 .. m_max], transforms of the weights, contribute. `lanes` as
/// in zernike_adjoint.
void polar_adjoint(InstructionSet set, const ZernikeRows& rows, double slope_unit, const RingBlock& rings,
                   const RingOrder* orders, std::vector<CacheLine>* lanes, double* packed);

}  // namespace aberfit::internal
