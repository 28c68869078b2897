#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// Reflected rays near the focal plane z = f. A ray is where it meets that plane and how it moves per unit of
/// dz = z - f: X(dz) = x + dz * tx. Lost rays (1 - |grad z|^2 <= 0: reflected away from the focus; or a
/// height or slope that is not finite) are zero, have weight 0 and are counted.
struct RayBundle {
  Eigen::ArrayXd x, y;    ///< crossing of the plane z = f [m]
  Eigen::ArrayXd tx, ty;  ///< dX/dz, dY/dz
  Eigen::ArrayXd weight;  ///< share of the light; sums to 1 less the lost share
  Eigen::Index lost = 0;  ///< number of lost rays
  Eigen::Index size() const { return x.size(); }
};

/// One reflected ray: crossing of the plane z = focal_length and slope of the ray against the axis.
template <typename T>
struct Ray {
  T x, y;    ///< [m]
  T tx, ty;  ///< dX/dz, dY/dz
};

/// Light along (0,0,-1) met by the surface point (x, y, height) with slopes (p, q) leaves along (-2p, -2q,
/// 1-g2)/(1+g2), g2 = p^2+q^2 (law of reflection, PHYSICS 1). Closed form, no intersection search. Not
/// defined for g2 >= 1.
template <typename T>
Ray<T> reflect(double focal_length, const T& x, const T& y, const SurfacePoint<T>& s) {
  const T scale = -2.0 / (1.0 - s.slope_x * s.slope_x - s.slope_y * s.slope_y);
  const T tx = s.slope_x * scale, ty = s.slope_y * scale;
  const T path = focal_length - s.height;
  return {x + path * tx, y + path * ty, tx, ty};
}

/// Traces the mirror plus the surface error `field` (height and slopes at the pupil points, same size).
/// `reflect` of `base_surface` plus field for many rays at once, equal to it within 1e-15 m and 1e-13 of the
/// value.
RayBundle trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field);
/// The same into a bundle whose memory is reused, on `threads` threads; rays do not depend on their number.
void trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field, int threads,
           RayBundle* rays);

/// Traces the mirror without surface error: the nominal rays.
RayBundle trace_nominal(const Mirror& mirror, const PupilSample& pupil, int threads = 1);

/// Gradient of one number with respect to the rays it depends on: entry k of a component belongs to ray
/// rays[k] (a ray may be listed more than once; its entries add up), or to ray k where `all_rays`. Rays not
/// listed have none. A component left empty is zero throughout. `dz`: d_x and d_y are with respect to the
/// crossing of the plane z = f + dz, so that dz d_x and dz d_y count on tx and ty, besides d_tx and d_ty.
struct RayGradient {
  std::vector<std::uint32_t> rays;
  std::vector<double> d_x, d_y, d_tx, d_ty;
  double dz = 0;  ///< [m]
  bool all_rays = false;

  /// Back to no rays; memory is kept.
  void clear() {
    rays.clear();
    for (std::vector<double>* component : {&d_x, &d_y, &d_tx, &d_ty}) component->clear();
    dz = 0;
    all_rays = false;
  }
};

/// Pulls a ray gradient back to the surface error (height, slope_x, slope_y) of the same rays: the adjoint of
/// `trace`. Result entry k belongs to the ray of entry k of the gradient.
SurfaceField trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                           const RayGradient& gradient);
/// The same into a field whose memory is reused where the size stays.
void trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                   const RayGradient& gradient, SurfaceField* result);

}  // namespace aberfit
