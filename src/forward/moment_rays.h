#pragma once
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "ray_forward.h"

namespace aberfit::internal {

/// Moments are computed on points that are exact for the order of the terms, whatever else is.
inline bool is_moment(const Statistic& statistic) { return kind_of(statistic).is_moment; }

/// A moment of terms and scatter together: heights and slopes add in squares, and the mean angle as if the
/// slopes of the terms were Gaussian, too (a Rayleigh mean). scatter: null without any.
double with_scatter(const MeanScatter* scatter, const Statistic& moment, double of_terms);

/// Rays of the mirror through a pupil of their own. Moments are of the roughness: what segments stand apart
/// is left out.
class MomentRays {
 public:
  MomentRays(const Mirror& mirror, PupilSample pupil, const TermSet& terms, const OperatorOptions& how,
             const std::vector<Statistic>& moments);
  MomentRays(const MomentRays&) = delete;
  MomentRays& operator=(const MomentRays&) = delete;
  RayForward& rays() { return rays_; }
  /// Coefficients of all terms.
  void move_to(const Eigen::VectorXd& coefficients) {
    rays_.move_to(coefficients.head(surface_.terms().size()));
  }

 private:
  PupilSample pupil_;
  SurfaceOperator surface_;  // on pupil_
  RayForward rays_;          // through both
};

/// On the points of moment_pupil, or of mean_angle_pupil where the mean angle is among the statistics, which
/// are moments all; null where there is no such pupil.
std::unique_ptr<MomentRays> make_moment_rays(const Mirror& mirror, const Aperture& aperture,
                                             const TermSet& terms, const std::vector<Statistic>& moments,
                                             int threads);

}  // namespace aberfit::internal
