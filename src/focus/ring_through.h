#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "aberfit/trace/ray_bundle.h"
#include "focus_kernel.h"

namespace aberfit::internal {

/// Full width at half maximum of N(z), the encircled energy of a fixed ring about the nominal axis or
/// centroid.
struct RingWidth {
  double fwhm = 0;                  ///< [m]
  double lower = 0, upper = 0;      ///< half-maximum crossings next to the peak, dz [m]
  double peak = 0, peak_share = 0;  ///< plane of the largest N [m], and N there
  int crossings = 2;  ///< crossings of the half maximum in the search range; more than 2: several peaks
};

/// A ring of fixed radius [m] about a fixed centre.
struct Ring {
  double radius = 0, centre_x = 0, centre_y = 0;
};

/// Rays that the kernel may touch in a window of planes.
struct RingShell {
  std::vector<double> x, y, tx, ty, weight;
  std::vector<std::uint32_t> ray;
  std::size_t used = 0;
  RayBlock block(std::size_t first, std::size_t most) const;  ///< padded
};

/// Memory that calls reuse.
struct RingBuffers {
  std::vector<double> enter, leave;  // [group][plane]
  std::vector<double> share;         // per plane
  std::vector<RingShell> shells;     // [window][group]
  std::vector<double> inside;        // [group][window]
};

/// Counts N exactly on a fine grid of planes, where each ray contributes one interval of z. Crossings are
/// interpolated with a relative error below 1e-5. Returns nothing when N does not fall to half on both sides
/// within 128 ring/slope lengths.
std::optional<RingWidth> exact_ring_width(const RayBundle& rays, const RaySums& sums, const Ring& ring,
                                          int threads, RingBuffers* buffers);

/// The smooth version: N with the kernel integral of half-width `width` in radius. Its peak and crossings
/// come from root finding over the rays that the kernel may touch near them. `gradient`, when given, becomes
/// d fwhm at fixed ring radius, dense when `dense`. d_ring is d fwhm / d ring radius.
std::optional<RingWidth> smooth_ring_width(const RayBundle& rays, const RaySums& sums, const Ring& ring,
                                           double width, int threads, RingBuffers* buffers, bool dense,
                                           RayGradient* gradient, double* d_ring);

}  // namespace aberfit::internal
