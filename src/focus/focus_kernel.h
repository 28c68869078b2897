#pragma once
#include <cstdint>

#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Rays per kernel call; their intermediate values stay in the first-level cache.
constexpr int kBlockRays = 512;
/// The number of rays given to a kernel is a multiple of this.
constexpr int kRayPadding = 8;

/// A sequence of rays. `count` is a multiple of kRayPadding; padding has weight 0.
struct RayBlock {
  const double *x, *y, *tx, *ty, *weight;
  int count;
};

struct RaySums {
  double weight = 0, x = 0, y = 0, tx = 0, ty = 0, slope2 = 0;  // slope2: sum of tx^2 + ty^2
};

/// A plane, the centre of its circles and its bins of r^2. The bin is given by the leading bits of r^2,
/// clamped to [low, high] and counted from `offset`. The bits of a positive double increase with its value,
/// so bins are ordered. Their width relative to r^2 lies between 2^-kBinBits and half of that.
constexpr int kBinBits = 6;
struct BinnedPlane {
  double dz = 0, centre_x = 0, centre_y = 0;
  double low = 0, high = 0;
  std::int64_t offset = 0;
};

/// The smooth disc of kernel.h with a centre, in the form that the kernels use.
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
  void (*sums)(const RayBlock& rays, RaySums* sums);
  /// r2[i]: squared distance from the centre in the plane; bin[i]: its bin. Repeated calls give the same
  /// bits.
  void (*bins)(const RayBlock& rays, const BinnedPlane& plane, double* r2, std::int32_t* bin);
  /// Summed over rays: sums[0] += weight share(r2), sums[1] += weight radius d share / d radius.
  void (*count)(const double* r2, const double* weight, int n, const DiscShape& disc, double* sums);
  /// density[i] = weight * density(r2).
  void (*density)(const double* r2, const double* weight, int n, const DiscShape& disc, double* density);
  /// enter: the first plane at which a ray is inside the ring. leave: the first later plane at which it is
  /// outside. Both are in units of the pitch from `first`, clamped to [0, planes + 1]. Both are planes + 2
  /// for a ray that misses the ring.
  void (*intervals)(const RayBlock& rays, double centre_x, double centre_y, double ring2, double first,
                    double planes_per_metre, int planes, std::int32_t* enter, std::int32_t* leave);
  /// Sets bit w of flags[i] if the squared distance of a ray may lie between inside2 and outside2 somewhere
  /// in window w. Adds to inside[w] the weight of rays that are nearer throughout the window.
  void (*classify)(const RayBlock& rays, double centre_x, double centre_y, double inside2, double outside2,
                   int windows, const PlaneWindow* window, std::int32_t* flags, double* inside);
  /// At plane z, summed over rays: sums[0] += weight share, sums[1] += weight d share / d z, sums[2] +=
  /// weight radius d share / d radius.
  void (*share)(const RayBlock& rays, double z, const DiscShape& disc, double* sums);
  /// density[i] = weight * density(r2) at plane z.
  void (*share_density)(const RayBlock& rays, double z, const DiscShape& disc, double* density);
  /// sums[0] += weight angle^2, sums[1] += weight angle, for angles between (tx, ty) and the nominal
  /// directions. Returns false, and the sums are invalid, if an angle reaches 1/16 rad.
  bool (*angles)(const RayBlock& rays, const double* nominal_tx, const double* nominal_ty, double* sums);
  /// d_tx, d_ty = scale * weight * d(angle^2/2), or d(angle) when `mean` (0 for a zero angle). Returns false,
  /// and the output is invalid, if an angle reaches 1/16 rad.
  bool (*angle_gradient)(const RayBlock& rays, const double* nominal_tx, const double* nominal_ty,
                         double scale, bool mean, double* d_tx, double* d_ty);
};

const FocusKernels& focus_kernels(InstructionSet set);

}  // namespace aberfit::internal
