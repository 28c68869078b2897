#pragma once
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "ray_forward.h"

namespace aberfit::internal {

/// Statistics in two lists with their original indices: those that waves compute themselves, and moments of
/// the traced surface, which are computed on points that are exact for the order of the terms.
struct SplitStatistics {
  std::vector<Statistic> own, geometric;
  std::vector<std::size_t> own_place, geometric_place;

  explicit SplitStatistics(const std::vector<Statistic>& all) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const bool moment = kind_of(all[k]).is_moment();
      (moment ? geometric : own).push_back(all[k]);
      (moment ? geometric_place : own_place).push_back(k);
    }
  }
};

/// A moment of terms and scatter together. Heights and slopes add in squares; the mean angle assumes Gaussian
/// slopes of the terms as well (a Rayleigh mean). scatter: null without any.
double with_scatter(const MeanScatter* scatter, const Statistic& moment, double of_terms);

/// Rays of the mirror through a separate pupil. Moments describe the roughness without segment errors.
class MomentRays {
 public:
  MomentRays(const Mirror& mirror, PupilSample pupil, const TermSet& terms, const OperatorOptions& how,
             const std::vector<Statistic>& moments);
  MomentRays(const MomentRays&) = delete;
  MomentRays& operator=(const MomentRays&) = delete;
  RayForward& rays() { return rays_; }
  /// coefficients: of all terms.
  void move_to(const Eigen::VectorXd& coefficients) {
    rays_.move_to(coefficients.head(surface_.terms().size()));
  }

 private:
  PupilSample pupil_;
  SurfaceOperator surface_;  // on pupil_
  RayForward rays_;          // through both
};

/// Uses the points of moment_pupil, or of mean_angle_pupil where the mean angle is among the statistics, all
/// of which are moments. Null where there is no such pupil.
std::unique_ptr<MomentRays> make_moment_rays(const Mirror& mirror, const Aperture& aperture,
                                             const TermSet& terms, const std::vector<Statistic>& moments,
                                             int threads);

}  // namespace aberfit::internal
