#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "aberfit/trace/ray_bundle.h"
#include "focus_kernel.h"

namespace aberfit::internal {

/// An encircled-energy radius that is wanted, or the other way round the share inside a radius.
struct RadiusRequest {
  double dz = 0, fraction = 0;
  RayGradient* gradient = nullptr;  ///< of the smooth result, when given
  double radius = std::nan("");  ///< result; NaN when the kernel is wider than the spot or no ray lies near
  bool of_share = false;         ///< `radius` is given, `fraction` is the result
};

/// Rays of a few bins: squared distance, weight, which ray.
struct RadiusShell {
  std::vector<double> r2, weight;
  std::vector<std::uint32_t> ray;
  std::size_t used = 0;
  std::size_t padded() const { return (used + kRayPadding - 1) / kRayPadding * kRayPadding; }
};

/// One plane on its way from rays to radii; memory is kept from call to call.
struct RadiusPlane {
  struct Search {
    std::size_t request;
    int first_bin = 0, last_bin = 0;  // whose rays decide
    bool every_bin = false;           // no bracket: start from the exact radius
    bool too_small = false;           // the kernel is wider than the spot
    double low = 0, high = 0;         // the radius lies between
    int interval = 0;
  };
  struct Interval {
    int first_bin, last_bin;
  };
  BinnedPlane binned;
  std::vector<Search> searches;
  std::vector<Interval> intervals;   // union of the searches' bins, disjoint, rising
  std::vector<double> histogram;     // [group][bin][4]: four sums side by side, added to in turn
  std::vector<double> bins, before;  // weight in each bin, in all earlier ones
  std::vector<std::uint16_t> slot;   // per bin: 1 + its interval, or 0
  std::vector<RadiusShell> shells;   // [interval][group]
};

struct RadiusBuffers {
  std::vector<RadiusPlane> planes;
  std::vector<std::size_t> order;
};

/// Turns a gradient about a fixed centre into that about the centroid, which moves with every ray: what d_x
/// and d_y sum to is taken back in shares of the weight. Rays listed must rise. Dense afterwards; d_tx and
/// d_ty as they were, so they must be empty or dense.
void follow_centroid(const RayBundle& rays, double total, RayGradient* gradient);

/// Radii about the nominal axis or each plane's centroid that hold the wanted fractions of the weight.
///
/// width = 0: the exact order statistic. Each ray counts half at its own radius, linear in between.
/// width > 0: the root of smooth count = fraction of the weight (kernel.h), to 1e-11 of the radius, with
/// gradients.
///
/// Two passes over the rays per plane: weights into bins of r^2 (no square root, no sort), then the rays of
/// those few bins that can matter. The bins bound the smooth count from both sides (all weight at a bin's
/// near edge, all at its far edge), hence the radius; no ray outside of what is collected can touch the
/// kernel anywhere between.
void encircled_radii(const RayBundle& rays, const RaySums& sums, bool about_centroid, double width,
                     int threads, RadiusBuffers* buffers, std::vector<RadiusRequest>* requests);

}  // namespace aberfit::internal
