#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "aberfit/trace/ray_bundle.h"
#include "kernel.h"

namespace aberfit {

/// The rays of one plane ordered into bins of distance from a centre: one counting pass instead of a sort,
/// after which quantiles and smooth counts only look at the rays of a few bins.
class RadialDistribution {
 public:
  RadialDistribution(const RayBundle& rays, double dz, bool about_centroid);

  double total_weight() const { return total_; }
  double rms() const { return rms_; }

  /// Exact radius that holds `fraction` of the weight: each ray counts half at its own radius, linear in
  /// between.
  double exact_radius(double fraction) const;

  /// Smooth count: weight within `radius` when every indicator is replaced by the kernel integral of
  /// half-width `width`; density is its derivative.
  struct Count {
    double weight, density;
  };
  Count smooth_count(double radius, double width) const;
  /// Radius at which the smooth count is `fraction` of the weight; nothing when the kernel is wider than the
  /// spot or no ray lies near.
  std::optional<double> smooth_radius(double fraction, double width) const;

  /// Gradient of the smooth radius (times `scale`) over the rays, appended to `gradient`.
  void radius_gradient(double radius, double width, double scale, RayGradient* gradient) const;
  /// Gradient of the smooth count at fixed radius (times `scale`), appended to `gradient`.
  void count_gradient(double radius, double width, double scale, RayGradient* gradient) const;

 private:
  std::size_t bin_of(double r) const;
  template <typename Visit>
  void visit_shell(const SmoothDisc& disc, const Visit& visit) const;

  const RayBundle& rays_;
  double dz_;
  bool about_centroid_;
  double centre_x_ = 0, centre_y_ = 0;
  double total_ = 0, rms_ = 0, bins_per_metre_ = 0;
  std::vector<double> radius_;         // by ray
  std::vector<std::uint32_t> order_;   // rays by bin
  std::vector<std::uint32_t> first_;   // first place in order_ of each bin, one more than bins
  std::vector<double> weight_before_;  // weight in all earlier bins
};

}  // namespace aberfit
