#pragma once
#include <variant>

#include "aberfit/forward/forward_model.h"
#include "ray_forward.h"

namespace aberfit::internal {

/// Statistics that are integrals over height and slope of the surface, not counts of rays: they are computed
/// on points that are exact for the order of the terms, whatever else is.
inline bool is_moment(const Statistic& statistic) {
  return std::holds_alternative<ScatterRms>(statistic) || std::holds_alternative<ScatterMean>(statistic) ||
         std::holds_alternative<RmsHeight>(statistic);
}

/// The mirror's rays through the points of moment_pupil: for statistics that are moments, and those only.
class MomentRays {
 public:
  MomentRays(const Mirror& mirror, const Aperture& aperture, const TermSet& terms,
             const std::vector<Statistic>& moments, int threads);
  MomentRays(const MomentRays&) = delete;
  MomentRays& operator=(const MomentRays&) = delete;
  RayForward& rays() { return rays_; }

 private:
  PupilSample pupil_;
  SurfaceOperator surface_;  // on pupil_
  RayForward rays_;          // through both
};

}  // namespace aberfit::internal
