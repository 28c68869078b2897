#include "aberfit/theory/ray_perturbation.h"

#include <cassert>
#include <cmath>

#include "aberfit/core/random.h"
#include "aberfit/trace/nominal_surface.h"

namespace aberfit {
namespace {

// The reflected unit vector of the nominal ray plus (-ex, -ey, 0). Its length does not matter.
Ray<double> deflect(double focal_length, double x, double y, const SurfacePoint<double>& s, double ex,
                    double ey) {
  const double g2 = s.slope_x * s.slope_x + s.slope_y * s.slope_y;
  const double ux = -2.0 * s.slope_x / (1.0 + g2) - ex, uy = -2.0 * s.slope_y / (1.0 + g2) - ey;
  const double uz = (1.0 - g2) / (1.0 + g2), path = focal_length - s.height;
  return {x + path * ux / uz, y + path * uy / uz, ux / uz, uy / uz};
}

}  // namespace

RayBundle trace_perturbed(const Mirror& mirror, const PupilSample& pupil, double slope, Convention convention,
                          std::uint64_t seed) {
  const RandomStream stream(seed, "harvey-shack");
  Eigen::Array2Xd slope_error(2, pupil.size());
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const auto deviate = stream.normal_pair(std::uint64_t(i));
    slope_error(0, i) = slope * deviate[0];
    slope_error(1, i) = slope * deviate[1];
  }
  return trace_perturbed(mirror, pupil, slope_error, convention);
}

RayBundle trace_perturbed(const Mirror& mirror, const PupilSample& pupil, const Eigen::Array2Xd& slope_error,
                          Convention convention) {
  const Eigen::Index n = pupil.size();
  assert(slope_error.cols() == n);
  RayBundle rays;
  rays.x.resize(n);
  rays.y.resize(n);
  rays.tx.resize(n);
  rays.ty.resize(n);
  rays.weight = pupil.weight;
  const SurfaceField known = known_zernike_field(mirror, pupil);
  const Mirror of_revolution = without_known_zernikes(mirror);
  for (Eigen::Index i = 0; i < n; ++i) {
    SurfacePoint<double> s = base_surface(of_revolution, pupil.x[i], pupil.y[i]);
    if (known.size() > 0) {
      s.height += known.height[i];
      s.slope_x += known.slope_x[i];
      s.slope_y += known.slope_y[i];
    }
    const double ex = slope_error(0, i), ey = slope_error(1, i);
    if (convention == Convention::kPhysical) {
      s.slope_x += ex;
      s.slope_y += ey;
    }
    // In this form a slope that is not a number counts as lost, too.
    const bool returns = s.slope_x * s.slope_x + s.slope_y * s.slope_y < 1.0 && std::isfinite(ex + ey);
    Ray<double> ray{};
    if (returns)
      ray = convention == Convention::kPhysical
                ? reflect(mirror.focal_length, pupil.x[i], pupil.y[i], s)
                : deflect(mirror.focal_length, pupil.x[i], pupil.y[i], s, ex, ey);
    rays.x[i] = ray.x;
    rays.y[i] = ray.y;
    rays.tx[i] = ray.tx;
    rays.ty[i] = ray.ty;
    if (!returns) {
      rays.weight[i] = 0.0;
      ++rays.lost;
    }
  }
  return rays;
}

}  // namespace aberfit
