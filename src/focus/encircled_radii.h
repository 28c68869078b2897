#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "aberfit/trace/ray_bundle.h"
#include "focus_kernel.h"

namespace aberfit::internal {

/// A request for an encircled-energy radius, or for the encircled energy of a given radius.
struct RadiusRequest {
  double dz = 0, fraction = 0;
  RayGradient* gradient = nullptr;  ///< gradient of the smooth result, when given
  double radius = std::nan("");  ///< result; NaN when the kernel is wider than the spot or no ray lies near
  bool of_share = false;         ///< true: `radius` is given and `fraction` is the result
};

/// Rays of a few bins: squared distance, weight and index of each ray.
struct RadiusShell {
  std::vector<double> r2, weight;
  std::vector<std::uint32_t> ray;
  std::size_t used = 0;
  std::size_t padded() const { return (used + kRayPadding - 1) / kRayPadding * kRayPadding; }
};

/// State of one plane; its memory is reused from call to call.
struct RadiusPlane {
  struct Search {
    std::size_t request;
    int first_bin = 0, last_bin = 0;  // range of bins whose rays are needed
    bool every_bin = false;           // no bracket exists; the search starts from the exact radius
    bool too_small = false;           // the kernel is wider than the spot
    double low = 0, high = 0;         // bracket of the radius
    int interval = 0;
  };
  struct Interval {
    int first_bin, last_bin;
  };
  BinnedPlane binned;
  std::vector<Search> searches;
  std::vector<Interval> intervals;   // union of the searches' bins, disjoint and increasing
  std::vector<double> histogram;     // [group][bin][4]: four sums side by side, used in turn
  std::vector<double> bins, before;  // weight in each bin, and in all earlier bins
  std::vector<std::uint16_t> slot;   // per bin: 1 + its interval, or 0
  std::vector<RadiusShell> shells;   // [interval][group]
};

struct RadiusBuffers {
  std::vector<RadiusPlane> planes;
  std::vector<std::size_t> order;
};

/// Converts a gradient about a fixed centre into one about the centroid, which depends on every ray. The sums
/// of d_x and d_y are subtracted in proportion to the weights. Listed ray numbers must increase. d_x and d_y
/// become dense; d_tx and d_ty do not change, so they must be empty or dense.
void follow_centroid(const RayBundle& rays, double total, RayGradient* gradient);

/// Radii about the nominal axis, or about each plane's centroid, that hold the wanted fractions of the
/// weight.
/// width = 0: the exact order statistic. Each ray counts half at its own radius; the count is linear in
/// between.
/// width > 0: the root of smooth count = fraction of the weight (kernel.h), to 1e-11 of the radius, with
/// gradients.
/// Each plane takes two passes over the rays. The first adds weights to bins of r^2, without square roots or
/// sorting. The bins bound the smooth count from both sides: all weight at a bin's near edge, or at its far
/// edge. This brackets the radius. The second pass collects the rays of the bins that the kernel can touch
/// inside the bracket.
void encircled_radii(const RayBundle& rays, const RaySums& sums, bool about_centroid, double width,
                     int threads, RadiusBuffers* buffers, std::vector<RadiusRequest>* requests);

}  // namespace aberfit::internal
