// The vector kernels of trace against `base_surface` and `reflect`, which define it.
#include "../../src/trace/trace_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "aberfit/core/random.h"
#include "aberfit/trace/ray_bundle.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

// The error bound in the declaration of `trace`.
constexpr double kAbsolute = 1e-15, kRelative = 1e-13;

std::vector<Mirror> mirrors() {
  Mirror parabola, ellipse, asphere, sphere;
  parabola.focal_length = ellipse.focal_length = asphere.focal_length = 2.8;
  sphere.focal_length = 0.15;  // sag defined up to 0.3 m
  ellipse.conic = -0.4;
  sphere.conic = 0;
  asphere.spherical = {1e-3, -2e-2, 0.3, 1.0, -5.0};
  return {parabola, ellipse, asphere, sphere};
}

SurfaceField rough_field(const PupilSample& pupil, double slope) {
  SurfaceField field;
  field.resize(pupil.size());
  const RandomStream stream(7, "trace-kernel-test");
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    field.slope_x[i] = slope * a;
    field.slope_y[i] = slope * b;
    field.height[i] = 1e-3 * slope * stream.normal(std::uint64_t(2 * i + 1));
  }
  return field;
}

void expect_close(double found, double expected) {
  EXPECT_LE(std::abs(found - expected), kAbsolute + kRelative * std::abs(expected))
      << found << " " << expected;
}

}  // namespace

TEST(TraceKernel, AgreesWithTheScalarTemplatesInEveryInstructionSet) {
  constexpr int kCount = 512;
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, kCount, 5});
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    for (const Mirror& mirror : mirrors()) {
      for (const double slope : {0.0, 1e-5, 1e-2, 0.6}) {  // 0.6: a third of the rays is lost
        const SurfaceField field = rough_field(pupil, slope);
        std::vector<double> out[5];
        for (auto& o : out) o.assign(kCount, -1.0);
        const int lost =
            trace_run(set, mirror, kCount, pupil.x.data(), pupil.y.data(), pupil.weight.data(),
                      {field.height.data(), field.slope_x.data(), field.slope_y.data()},
                      {out[0].data(), out[1].data(), out[2].data(), out[3].data(), out[4].data()});
        int expected_lost = 0;
        for (Eigen::Index i = 0; i < kCount; ++i) {
          SurfacePoint<double> s = base_surface(mirror, pupil.x[i], pupil.y[i]);
          s.height += field.height[i];
          s.slope_x += field.slope_x[i];
          s.slope_y += field.slope_y[i];
          const double g2 = s.slope_x * s.slope_x + s.slope_y * s.slope_y;
          const auto k = std::size_t(i);
          if (g2 < 1.0) {
            const Ray<double> ray = reflect(mirror.focal_length, pupil.x[i], pupil.y[i], s);
            // The rounding error of 1 - g2 grows by 1/(1 - g2).
            if (1.0 - g2 > 0.05) {
              expect_close(out[0][k], ray.x);
              expect_close(out[1][k], ray.y);
              expect_close(out[2][k], ray.tx);
              expect_close(out[3][k], ray.ty);
            }
            EXPECT_EQ(out[4][k], pupil.weight[i]);
          } else {
            ++expected_lost;
            for (const auto& o : out) EXPECT_EQ(o[k], 0.0);
          }
        }
        EXPECT_EQ(lost, expected_lost);
      }
    }
  }
}

TEST(TraceKernel, ARayWithoutAFiniteHeightOrSlopeIsLostInEveryInstructionSet) {
  // Every lane of the widest vector, and the last points, which go through padded copies in `trace`.
  constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()};
  constexpr int kCount = 16;
  const PupilSample pupil = make_pupil(CircleAperture{0.2, 0}, {PupilLayout::kRandom, kCount + 3, 5});
  for (const Mirror& mirror : mirrors())
    for (const double bad : kBad)
      for (int component = 0; component < 3; ++component)
        for (Eigen::Index i = 0; i < pupil.size(); ++i) {
          SurfaceField field = rough_field(pupil, 1e-5);
          Eigen::ArrayXd* const part[3] = {&field.height, &field.slope_x, &field.slope_y};
          (*part[component])[i] = bad;
          const RayBundle rays = trace(mirror, pupil, field);
          EXPECT_EQ(rays.lost, 1) << bad << ' ' << component << ' ' << i;
          EXPECT_EQ(rays.weight[i], 0);
          EXPECT_TRUE(rays.x[i] == 0 && rays.y[i] == 0 && rays.tx[i] == 0 && rays.ty[i] == 0);
          EXPECT_TRUE(rays.x.allFinite() && rays.y.allFinite());
          if (i >= kCount) continue;
          for (const InstructionSet set :
               {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
            if (!is_supported(set)) continue;
            std::vector<double> out[5];
            for (auto& o : out) o.assign(kCount, -1.0);
            EXPECT_EQ(trace_run(set, mirror, kCount, pupil.x.data(), pupil.y.data(), pupil.weight.data(),
                                {field.height.data(), field.slope_x.data(), field.slope_y.data()},
                                {out[0].data(), out[1].data(), out[2].data(), out[3].data(), out[4].data()}),
                      1);
            for (const auto& o : out) EXPECT_EQ(o[std::size_t(i)], 0.0);
          }
        }
}

TEST(TraceKernel, RunsThatFillNoVectorAndThreadsChangeNothing) {
  for (const Mirror& mirror : mirrors()) {
    for (const Eigen::Index n : {1, 7, 8, 9, 511, 513, 40001}) {
      const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, n, 6});
      SurfaceField field = rough_field(pupil, 1e-3);
      field.slope_x[n / 2] = 2.0;
      RayBundle one, three;
      trace(mirror, pupil, field, 1, &one);
      trace(mirror, pupil, field, 3, &three);
      EXPECT_EQ(one.lost, 1);
      EXPECT_EQ(three.lost, 1);
      EXPECT_TRUE((one.x == three.x).all() && (one.y == three.y).all() && (one.tx == three.tx).all() &&
                  (one.ty == three.ty).all() && (one.weight == three.weight).all());
      const Eigen::Index last = n - 1;
      if (last == n / 2) continue;
      const SurfacePoint<double> base = base_surface(mirror, pupil.x[last], pupil.y[last]);
      const Ray<double> ray = reflect(mirror.focal_length, pupil.x[last], pupil.y[last],
                                      {base.height + field.height[last], base.slope_x + field.slope_x[last],
                                       base.slope_y + field.slope_y[last]});
      expect_close(one.x[last], ray.x);
      expect_close(one.ty[last], ray.ty);
      EXPECT_EQ(one.weight[last], pupil.weight[last]);
    }
  }
}

TEST(Trace, ReusesTheMemoryOfTheBundle) {
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 1000, 6});
  const SurfaceField field = rough_field(pupil, 1e-5);
  RayBundle rays;
  trace(mirrors()[0], pupil, field, 1, &rays);
  const double* const x = rays.x.data();
  const double* const weight = rays.weight.data();
  trace(mirrors()[0], pupil, field, 2, &rays);
  EXPECT_EQ(rays.x.data(), x);
  EXPECT_EQ(rays.weight.data(), weight);
}

TEST(Trace, AdjointOfAllRaysEqualsThatOfTheSameRaysListed) {
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 777, 8});
  const SurfaceField field = rough_field(pupil, 1e-3);
  const RandomStream stream(5, "adjoint-all-rays");
  RayGradient dense, listed;
  dense.all_rays = true;
  dense.dz = 1.5e-3;
  for (std::uint32_t i = 0; i < 777; ++i) {
    dense.d_x.push_back(stream.normal(3 * i));
    dense.d_y.push_back(stream.normal(3 * i + 1));
    listed.rays.push_back(776 - i);
  }
  for (std::size_t k = 0; k < 777; ++k) {
    listed.d_x.push_back(dense.d_x[776 - k]);
    listed.d_y.push_back(dense.d_y[776 - k]);
    listed.d_tx.push_back(dense.dz * dense.d_x[776 - k]);
    listed.d_ty.push_back(dense.dz * dense.d_y[776 - k]);
  }
  for (const Mirror& mirror : mirrors()) {
    const SurfaceField a = trace_adjoint(mirror, pupil, field, dense),
                       b = trace_adjoint(mirror, pupil, field, listed);
    ASSERT_EQ(a.size(), 777);
    for (Eigen::Index i = 0; i < 777; ++i) {
      const double size = std::abs(dense.d_x[std::size_t(i)]) + std::abs(dense.d_y[std::size_t(i)]);
      EXPECT_NEAR(a.height[i], b.height[776 - i], 1e-14 * size);
      EXPECT_NEAR(a.slope_x[i], b.slope_x[776 - i], 1e-13 * size);
      EXPECT_NEAR(a.slope_y[i], b.slope_y[776 - i], 1e-13 * size);
    }
  }
}
