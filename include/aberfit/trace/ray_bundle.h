#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// Reflected rays near the focal plane z = f. A ray moves with dz = z - f as X(dz) = x + dz * tx. A ray is
/// lost where 1 - |grad z|^2 <= 0 (reflected away from the focus) or a height or slope is not finite. Lost
/// rays are zero, have weight 0 and are counted.
struct RayBundle {
  Eigen::ArrayXd x, y;    ///< crossing of the plane z = f [m]
  Eigen::ArrayXd tx, ty;  ///< dX/dz, dY/dz
  Eigen::ArrayXd weight;  ///< fraction of the energy; sums to 1 less the lost fraction
  Eigen::Index lost = 0;
  Eigen::Index size() const { return x.size(); }
};

/// One reflected ray: crossing of the plane z = focal_length and slope of the ray against the axis.
template <typename T>
struct Ray {
  T x, y;    ///< [m]
  T tx, ty;  ///< dX/dz, dY/dz
};

/// A ray along (0,0,-1) that meets the surface point (x, y, height) with slopes (p, q) leaves along (-2p,
/// -2q, 1-g2)/(1+g2), g2 = p^2+q^2 (law of reflection, PHYSICS 1). Closed form, for g2 < 1.
template <typename T>
Ray<T> reflect(double focal_length, const T& x, const T& y, const SurfacePoint<T>& s) {
  const T scale = -2.0 / (1.0 - s.slope_x * s.slope_x - s.slope_y * s.slope_y);
  const T tx = s.slope_x * scale, ty = s.slope_y * scale;
  const T path = focal_length - s.height;
  return {x + path * tx, y + path * ty, tx, ty};
}

/// Traces the mirror plus the surface error `field` (height and slopes at the pupil points, same size). It
/// equals `reflect` of `base_surface` plus field within 1e-15 m and 1e-13 of the value.
RayBundle trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field);
/// The same into a bundle whose memory is reused, on `threads` threads. Rays do not depend on their number.
void trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field, int threads,
           RayBundle* rays);

/// Traces the mirror without surface error: the nominal rays.
RayBundle trace_nominal(const Mirror& mirror, const PupilSample& pupil, int threads = 1);

/// Gradient of one number over the rays. Entry k of a component belongs to ray rays[k], or to ray k where
/// `all_rays`. Entries of a repeated ray add up; rays not listed and empty components are zero. d_x and d_y
/// refer to the crossing of the plane z = f + dz, so dz d_x and dz d_y add to d_tx and d_ty.
struct RayGradient {
  std::vector<std::uint32_t> rays;
  std::vector<double> d_x, d_y, d_tx, d_ty;
  double dz = 0;  ///< [m]
  bool all_rays = false;

  /// Removes all rays; memory is kept.
  void clear() {
    rays.clear();
    for (std::vector<double>* component : {&d_x, &d_y, &d_tx, &d_ty}) component->clear();
    dz = 0;
    all_rays = false;
  }
};

/// Converts a ray gradient into one over the surface error (height, slope_x, slope_y) of the same rays: the
/// adjoint of `trace`. Result entry k belongs to the ray of entry k of the gradient.
SurfaceField trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                           const RayGradient& gradient);
/// The same into a field whose memory is reused where the size is unchanged.
void trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                   const RayGradient& gradient, SurfaceField* result);

}  // namespace aberfit
