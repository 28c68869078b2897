#pragma once
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "ray_forward.h"

namespace aberfit::internal {

/// True for moments, which are computed on points that are exact for the order of the terms.
inline bool is_moment(const Statistic& statistic) { return kind_of(statistic).is_moment; }

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
