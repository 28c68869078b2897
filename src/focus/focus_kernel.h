#pragma once
#include <cstdint>

#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Rays one kernel call works on: what is computed of them stays in the first-level cache.
constexpr int kBlockRays = 512;
/// Counts given to kernels are multiples of this.
constexpr int kRayPadding = 8;

/// A run of rays; count is a multiple of kRayPadding, padding has weight 0.
struct RayBlock {
  const double *x, *y, *tx, *ty, *weight;
  int count;
};

/// Weighted sums over rays.
struct RaySums {
  double weight = 0, x = 0, y = 0, tx = 0, ty = 0, slope2 = 0;  // slope2: of tx^2 + ty^2
};

/// A plane, the centre of its circles and how its squared distances fall into bins: bin of r2 = leading bits
/// of r2 clamped to [low, high], counted from `offset`. The bits of a positive double grow with its value, so
/// bins are ordered and their width relative to r2 lies between 2^-kBinBits and half of that.
constexpr int kBinBits = 6;
struct BinnedPlane {
  double dz = 0, centre_x = 0, centre_y = 0;
  double low = 0, high = 0;
  std::int64_t offset = 0;
};

/// Smooth disc (kernel.h) as the kernels take it, here about a centre.
struct DiscShape {
  double centre_x, centre_y;
  double radius2, scale;
};

/// A window of planes [middle - half, middle + half].
struct PlaneWindow {
  double middle, half;
};
constexpr int kMostWindows = 3;

/// The inner loops of the focal statistics for one instruction set.
struct FocusKernels {
  /// Adds the sums of a block.
  void (*sums)(const RayBlock& rays, RaySums* sums);
  /// r2[i]: squared distance from the centre in the plane; bin[i]: its bin. The same bits whenever called.
  void (*bins)(const RayBlock& rays, const BinnedPlane& plane, double* r2, std::int32_t* bin);
  /// sums[0] += sum of weight share(r2), sums[1] += sum of weight d share / d radius2 seen as d_radius
  /// radius.
  void (*count)(const double* r2, const double* weight, int n, const DiscShape& disc, double* sums);
  /// density[i] = weight * density(r2).
  void (*density)(const double* r2, const double* weight, int n, const DiscShape& disc, double* density);
  /// First plane at or behind which a ray is inside the ring, first behind it from which it no longer is, in
  /// units of the pitch from `first`, clamped to [0, planes + 1]; both planes + 2 for a ray that misses the
  /// ring.
  void (*intervals)(const RayBlock& rays, double centre_x, double centre_y, double ring2, double first,
                    double planes_per_metre, int planes, std::int32_t* enter, std::int32_t* leave);
  /// Bit w of flags[i] is set where a ray may be at a squared distance between inside2 and outside2 somewhere
  /// in window w; inside[w] += weight of those that are nearer throughout.
  void (*classify)(const RayBlock& rays, double centre_x, double centre_y, double inside2, double outside2,
                   int windows, const PlaneWindow* window, std::int32_t* flags, double* inside);
  /// At plane z: sums[0] += weight share, sums[1] += d share / d z, sums[2] += radius d share / d radius.
  void (*share)(const RayBlock& rays, double z, const DiscShape& disc, double* sums);
  /// density[i] = weight * density(r2) at plane z.
  void (*share_density)(const RayBlock& rays, double z, const DiscShape& disc, double* density);
  /// sums[0] += weight angle^2, sums[1] += weight angle, between (tx, ty) and nominal directions. False, with
  /// sums spoilt, where an angle is not below 1/16 rad.
  bool (*angles)(const RayBlock& rays, const double* nominal_tx, const double* nominal_ty, double* sums);
  /// d_tx, d_ty = scale * weight * d(angle^2/2), or of d(angle) when `mean` (0 where there is no angle).
  /// False, with nothing of use written, where an angle is not below 1/16 rad.
  bool (*angle_gradient)(const RayBlock& rays, const double* nominal_tx, const double* nominal_ty,
                         double scale, bool mean, double* d_tx, double* d_ty);
};

const FocusKernels& focus_kernels(InstructionSet set);

}  // namespace aberfit::internal
