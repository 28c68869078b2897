#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

SurfacePoint<double> surface_at(const Mirror& mirror, const PupilSample& pupil, const SurfaceField* field,
                                Eigen::Index i) {
  SurfacePoint<double> s = base_surface(mirror, pupil.x[i], pupil.y[i]);
  if (field) {
    s.height += field->height[i];
    s.slope_x += field->slope_x[i];
    s.slope_y += field->slope_y[i];
  }
  return s;
}

RayBundle trace_any(const Mirror& mirror, const PupilSample& pupil, const SurfaceField* field) {
  const Eigen::Index n = pupil.size();
  RayBundle rays;
  rays.x.resize(n);
  rays.y.resize(n);
  rays.tx.resize(n);
  rays.ty.resize(n);
  rays.weight = pupil.weight;
  for (Eigen::Index i = 0; i < n; ++i) {
    const SurfacePoint<double> s = surface_at(mirror, pupil, field, i);
    const bool lost =
        !(s.slope_x * s.slope_x + s.slope_y * s.slope_y < 1.0);  // also when a slope is not a number
    const Ray<double> ray = lost ? Ray<double>{} : reflect(mirror.focal_length, pupil.x[i], pupil.y[i], s);
    rays.x[i] = ray.x;
    rays.y[i] = ray.y;
    rays.tx[i] = ray.tx;
    rays.ty[i] = ray.ty;
    if (lost) {
      rays.weight[i] = 0.0;
      ++rays.lost;
    }
  }
  return rays;
}

}  // namespace

RayBundle trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field) {
  return trace_any(mirror, pupil, &field);
}

void trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field, int /*threads*/,
           RayBundle* rays) {
  *rays = trace_any(mirror, pupil, &field);
}

RayBundle trace_nominal(const Mirror& mirror, const PupilSample& pupil) {
  return trace_any(mirror, pupil, nullptr);
}

SurfaceField trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                           const RayGradient& gradient) {
  SurfaceField result;
  result.resize(Eigen::Index(gradient.rays.size()));
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    const auto i = Eigen::Index(gradient.rays[std::size_t(k)]);
    const SurfacePoint<double> s = surface_at(mirror, pupil, &field, i);
    const double p = s.slope_x, q = s.slope_y, g = 1.0 - p * p - q * q;
    const double path = mirror.focal_length - s.height, scale = -2.0 / g, bend = -4.0 / (g * g);
    const double d_x = gradient.d_x[std::size_t(k)], d_y = gradient.d_y[std::size_t(k)];
    // x = X + path tx and tx = scale p, so everything on x counts on tx, times the path.
    const double d_tx = gradient.d_tx[std::size_t(k)] + path * d_x;
    const double d_ty = gradient.d_ty[std::size_t(k)] + path * d_y;
    const double along = bend * (p * d_tx + q * d_ty);  // through scale: d scale / dp = bend p
    result.height[k] = -scale * (p * d_x + q * d_y);
    result.slope_x[k] = scale * d_tx + p * along;
    result.slope_y[k] = scale * d_ty + q * along;
  }
  return result;
}

}  // namespace aberfit
