#include "aberfit/trace/ray_bundle.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "aberfit/core/random.h"
#include "aberfit/trace/central_difference.h"

using namespace aberfit;

namespace {

Mirror parabola() {
  Mirror mirror;
  mirror.focal_length = 2.8;
  return mirror;
}

// Random slopes and heights at every point, from a named stream.
SurfaceField rough_field(Eigen::Index n, double slope, double height) {
  SurfaceField field;
  field.resize(n);
  const RandomStream stream(1, "ray-bundle-test");
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    field.slope_x[i] = slope * a;
    field.slope_y[i] = slope * b;
    field.height[i] = height * stream.normal(std::uint64_t(2 * i + 1));
  }
  return field;
}

}  // namespace

TEST(Trace, IdealParabolaSendsEveryRayToItsFocus) {
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 10000, 1});
  const RayBundle rays = trace_nominal(parabola(), pupil);
  EXPECT_LT((rays.x.square() + rays.y.square()).sqrt().maxCoeff(),
            1e-15);  // rounding of terms of 0.2 m: 2e-16 expected
  EXPECT_EQ(rays.lost, 0);
}

TEST(Trace, ReflectsByTheVectorLaw) {
  // Second method: r = d - 2 (d.n) n with the unit normal, then a straight line to the plane.
  const Mirror mirror = [] {
    Mirror m = parabola();
    m.conic = -0.4;
    m.spherical[0] = 1e-4;
    return m;
  }();
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 2000, 2});
  const SurfaceField field = rough_field(pupil.size(), 1e-2, 1e-5);
  const RayBundle rays = trace(mirror, pupil, field);
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const auto base = base_surface(mirror, pupil.x[i], pupil.y[i]);
    const double p = base.slope_x + field.slope_x[i], q = base.slope_y + field.slope_y[i];
    const Eigen::Vector3d normal = Eigen::Vector3d(-p, -q, 1).normalized(), down(0, 0, -1);
    const Eigen::Vector3d out = down - 2 * down.dot(normal) * normal;
    const double path = (2.8 + 0.003 - base.height - field.height[i]) / out.z();
    EXPECT_NEAR(rays.x[i] + 0.003 * rays.tx[i], pupil.x[i] + path * out.x(), 1e-14);
    EXPECT_NEAR(rays.y[i] + 0.003 * rays.ty[i], pupil.y[i] + path * out.y(), 1e-14);
  }
}

TEST(Trace, SphereHasItsThirdOrderAberration) {
  // Sphere of radius 2f: a ray at height r crosses the axis at R - R/(2 cos i), sin i = r/R.
  Mirror sphere = parabola();
  sphere.conic = 0;
  PupilSample pupil{Eigen::ArrayXd::Constant(1, 0.15), Eigen::ArrayXd::Zero(1), Eigen::ArrayXd::Ones(1),
                    PupilLayout::kGrid};
  const RayBundle rays = trace_nominal(sphere, pupil);
  const double radius = 5.6, incidence = std::asin(0.15 / radius);
  const double axis_crossing = radius - radius / (2 * std::cos(incidence));
  EXPECT_NEAR(2.8 - rays.x[0] / rays.tx[0], axis_crossing, 1e-13);
}

TEST(Trace, CountsLostRaysAndGivesThemNoWeight) {
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 100, 1});
  SurfaceField field = rough_field(100, 1e-6, 1e-9);
  field.slope_x[3] = 1.5;
  field.slope_y[7] = std::nan("");
  const RayBundle rays = trace(parabola(), pupil, field);
  EXPECT_EQ(rays.lost, 2);
  EXPECT_NEAR(rays.weight.sum(), 0.98, 1e-14);
}

TEST(Trace, AdjointIsTheTransposeOfTheDerivative) {
  // <J v, g> = <v, J^T g>, with J v by a difference of the closed form.
  const Mirror mirror = parabola();
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 50, 3});
  const SurfaceField field = rough_field(50, 1e-3, 1e-6), direction = rough_field(50, 1.0, 1.0);
  RayGradient gradient;
  const RandomStream stream(4, "adjoint");
  for (std::uint32_t i = 0; i < 50; ++i) {
    gradient.rays.push_back(i);
    gradient.d_x.push_back(stream.normal(4 * i));
    gradient.d_y.push_back(stream.normal(4 * i + 1));
    gradient.d_tx.push_back(stream.normal(4 * i + 2));
    gradient.d_ty.push_back(stream.normal(4 * i + 3));
  }
  const auto moved = [&](double step) {
    SurfaceField f = field;
    f.height += step * direction.height;
    f.slope_x += step * direction.slope_x;
    f.slope_y += step * direction.slope_y;
    const RayBundle rays = trace(mirror, pupil, f);
    double sum = 0;
    for (Eigen::Index i = 0; i < 50; ++i) {
      const auto k = std::size_t(i);
      sum += gradient.d_x[k] * rays.x[i] + gradient.d_y[k] * rays.y[i] + gradient.d_tx[k] * rays.tx[i] +
             gradient.d_ty[k] * rays.ty[i];
    }
    return sum;
  };
  const double step = 1e-4;  // fourth-order difference: truncation step^4
  const double forward =
      (8 * (moved(step) - moved(-step)) - (moved(2 * step) - moved(-2 * step))) / (12 * step);
  const SurfaceField back = trace_adjoint(mirror, pupil, field, gradient);
  const double adjoint =
      (back.height * direction.height + back.slope_x * direction.slope_x + back.slope_y * direction.slope_y)
          .sum();
  EXPECT_NEAR(forward / adjoint, 1.0, 1e-9);
}

TEST(CentralDifference, LosesSlopeAsItsSecondOrderExpansionSays) {
  // One cosine of frequency f: the difference has sin(u)/u of the slope, u = 2 pi f d.
  TermSet terms;
  terms.radius = 0.2;
  terms.fourier = {{100, 0}};
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kPolar, 4096, 1});
  const Eigen::VectorXd c = Eigen::Vector2d(1e-7, 0);
  SurfaceField exact;
  SurfaceOperator(terms, pupil.x, pupil.y).apply(c, &exact);
  for (const double step : {1e-4, 3e-4, 1e-3}) {
    const SurfaceField seen = central_difference_field(parabola(), pupil, terms, c, step, 1);
    const double u = 2 * EIGEN_PI * 100 * step;
    const double ratio = std::sqrt(seen.slope_x.square().sum() / exact.slope_x.square().sum());
    EXPECT_NEAR(ratio, std::sin(u) / u, 1e-6) << step;  // rounding 1.2e-19/d over 4.4e-5 rad
  }
}
