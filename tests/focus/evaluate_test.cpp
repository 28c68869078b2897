#include "aberfit/focus/evaluate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "aberfit/core/random.h"

using namespace aberfit;

namespace {

constexpr double kF = 2.8, kR = 0.2;

Mirror parabola() {
  Mirror mirror;
  mirror.focal_length = kF;
  return mirror;
}

struct Scene {
  PupilSample pupil;
  RayBundle nominal, rays;
  SurfaceField field;
  FocusInput input() const { return {rays, nominal, field.height}; }
};

// Rays with independent Gaussian slope errors s. The focus is a Rayleigh distribution of sigma_f = 2 f s.
Scene gaussian_scene(Eigen::Index n, double slope, std::uint64_t seed,
                     PupilLayout layout = PupilLayout::kSobol) {
  Scene scene;
  scene.pupil = make_pupil(CircleAperture{2 * kR, 0}, {layout, n, seed});
  scene.field.resize(scene.pupil.size());
  const RandomStream stream(seed, "evaluate-test");
  for (Eigen::Index i = 0; i < scene.pupil.size(); ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    scene.field.slope_x[i] = slope * a;
    scene.field.slope_y[i] = slope * b;
    scene.field.height[i] = 1e-7 * stream.normal(std::uint64_t(2 * i + 1));
  }
  scene.nominal = trace_nominal(parabola(), scene.pupil);
  scene.rays = trace(parabola(), scene.pupil, scene.field);
  return scene;
}

}  // namespace

TEST(EncircledEnergy, UniformDiscMatchesClosedForm) {
  // The defocused ideal mirror gives a uniform disc of radius R |dz| / (f - z) to first order. ee_p is
  // sqrt(p) times the rim's radius.
  const PupilSample pupil = make_pupil(CircleAperture{2 * kR, 0}, {PupilLayout::kSobol, 1 << 17, 3});
  const RayBundle rays = trace_nominal(parabola(), pupil);
  const Eigen::ArrayXd height = Eigen::ArrayXd::Zero(rays.size());
  const double dz = 1e-3;
  for (const double p : {0.1, 0.5, 0.9}) {
    // |X| = dz * 2 (r/2f) / (1 - (r/2f)^2) increases with r, and the fraction p of the energy lies within r =
    // R sqrt(p).
    const double t = kR * std::sqrt(p) / (2 * kF), exact = dz * 2 * t / (1 - t * t);
    const double value = evaluate_exact({rays, rays, height}, {EncircledEnergyRadius{p, dz}}, 1)[0];
    EXPECT_NEAR(value / exact, 1.0, 2e-5);  // one of 2^17 points is 0.4e-5 of the radius
  }
}

TEST(EncircledEnergy, ExactRadiusIsTheInterpolatedOrderStatistic) {
  // Brute force over weighted points in one plane.
  const RandomStream stream(1, "order-statistic");
  for (const Eigen::Index n : {1, 2, 3, 10, 1000}) {
    RayBundle rays;
    rays.x.resize(n);
    rays.y.setZero(n);
    rays.tx.setZero(n);
    rays.ty.setZero(n);
    rays.weight.resize(n);
    std::vector<std::pair<double, double>> sorted;
    for (Eigen::Index i = 0; i < n; ++i) {
      rays.x[i] = std::exp(2 * stream.normal(std::uint64_t(i)));  // long tail: uses the overflow bin
      rays.weight[i] = stream.uniform(std::uint64_t(5000 + i));
      sorted.push_back({rays.x[i], rays.weight[i]});
    }
    std::sort(sorted.begin(), sorted.end());
    const double total = rays.weight.sum();
    for (const double p : {0.01, 0.3, 0.5, 0.9, 0.999}) {
      double below = 0, expected = sorted.front().first, previous = 0;
      for (std::size_t k = 0; k < sorted.size(); ++k) {
        const double here = below + sorted[k].second / 2;
        below += sorted[k].second;
        if (here >= p * total) {
          expected = k == 0 ? sorted[0].first
                            : sorted[k - 1].first + (sorted[k].first - sorted[k - 1].first) *
                                                        (p * total - previous) / (here - previous);
          break;
        }
        expected = sorted[k].first;
        previous = here;
      }
      const Eigen::ArrayXd none;
      EXPECT_NEAR(evaluate_exact({rays, rays, none}, {EncircledEnergyRadius{p, 0}}, 1)[0] / expected, 1.0,
                  1e-12)
          << n << " " << p;
    }
  }
}

TEST(FocusStatistics, GaussianFocusMatchesPhysics2) {
  const Eigen::Index n = 1 << 18;
  const double s = 1e-6;  // small-angle and paraxial error 0.064 % at f/7 (PHYSICS 5), sampling error ~0.13 %
  const Scene scene = gaussian_scene(n, s, 11);
  const double sigma = 2 * kF * s;
  const Eigen::VectorXd v =
      evaluate_exact(scene.input(),
                     {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.9, 0}, RingFwhm{}, ScatterRms{},
                      ScatterMean{}, SpotFwhm{0.1 * sigma}, RmsRadius{}, RmsHeight{}},
                     2);
  const double slack = 0.00064 + 4.5 * 0.0013;
  EXPECT_NEAR(v[0] / (1.17741002251547469 * sigma), 1.0, slack);
  EXPECT_NEAR(v[1] / (2.14596602628934724 * sigma), 1.0, slack);
  EXPECT_NEAR(v[2] / (2.80675976998768261 * v[1] * kF / kR), 1.0, slack);
  EXPECT_NEAR(v[3] / (std::sqrt(2.0) * 2 * s), 1.0, slack);
  EXPECT_NEAR(v[4] / v[3], 0.88622692545, slack);
  EXPECT_NEAR(v[5] / (2.3548200450309493 * std::sqrt(1.01) * sigma), 1.0,
              0.01);  // the kernel adds 1 % of variance; a peak converges slowly
  EXPECT_NEAR(v[6] / (std::sqrt(2.0) * sigma), 1.0, slack);
  EXPECT_NEAR(v[7] / 1e-7, 1.0, 4.5 / std::sqrt(2.0 * double(n)));
}

TEST(RingThrough, IdealMirrorHasTheClosedFormWidth) {
  // N(dz) = (ring f / (R dz))^2 beyond the plateau, so it is half at dz = sqrt2 ring f/R. The FWHM is 2 sqrt2
  // ring f/R, paraxially (t^2 = 1.3e-3 at the rim).
  const PupilSample pupil = make_pupil(CircleAperture{2 * kR, 0}, {PupilLayout::kSobol, 1 << 18, 5});
  const RayBundle rays = trace_nominal(parabola(), pupil);
  const Eigen::ArrayXd none;
  const double value = evaluate_exact({rays, rays, none}, {RingFwhm{0.9, 10e-6}}, 1)[0];
  EXPECT_NEAR(value / (2 * std::sqrt(2.0) * 10e-6 * kF / kR), 1.0, 2e-3);
}

// The library bins r^2 for many radii in a plane; this test counts every ray.
TEST(RingThrough, IsTheWeightOfTheRaysInside) {
  Scene scene = gaussian_scene(40000, 6e-6, 7);
  scene.rays.x[5] = scene.rays.y[5] = 0;  // a ray through the centre
  const double sigma = 2 * kF * 6e-6;
  const double inf = std::numeric_limits<double>::infinity();
  for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
    std::vector<Statistic> statistics;
    for (const double dz : {0.0, -0.6e-3, 2.5e-3})
      for (const double radius : {0.0, 1e-3 * sigma, 0.3 * sigma, sigma, 2.1 * sigma, 40 * sigma, 1.0, inf})
        statistics.push_back(RingThrough{radius, dz});
    statistics.push_back(EncircledEnergyRadius{0.5, -0.6e-3});  // uses the same bins
    const FocusInput input{scene.rays, scene.nominal, scene.field.height, centre};
    const Eigen::VectorXd exact = evaluate_exact(input, statistics, 2);
    for (std::size_t k = 0; k + 1 < statistics.size(); ++k) {
      const RingThrough s = std::get<RingThrough>(statistics[k]);
      const Eigen::ArrayXd x = scene.rays.x + s.dz * scene.rays.tx, y = scene.rays.y + s.dz * scene.rays.ty;
      const Eigen::ArrayXd& w = scene.rays.weight;
      const bool about = centre == Centre::kCentroid;
      const double cx = about ? (w * x).sum() / w.sum() : 0, cy = about ? (w * y).sum() / w.sum() : 0;
      const Eigen::ArrayXd r2 = (x - cx).square() + (y - cy).square();
      const double inside =
          s.ring_radius > 0 ? (r2 <= s.ring_radius * s.ring_radius).select(w, 0.0).sum() / w.sum() : 0.0;
      EXPECT_NEAR(exact[Eigen::Index(k)], inside, 1e-11) << s.ring_radius << " " << s.dz;
    }
    Eigen::VectorXd smooth;
    const std::vector<Statistic> one = {RingThrough{sigma, 2.5e-3}};
    ASSERT_TRUE(evaluate_smooth(input, one, 0.005 * sigma, 1, &smooth, nullptr));
    EXPECT_NEAR(smooth[0], evaluate_exact(input, one, 1)[0], 2e-4);
  }
  EXPECT_TRUE(std::isnan(evaluate_exact(scene.input(), {RingThrough{std::nan(""), 0}}, 1)[0]));
}

TEST(FocusStatistics, DoNotDependOnTheThreadCount) {
  const Scene scene = gaussian_scene(20000, 6e-6, 2);
  std::vector<Statistic> all = {EncircledEnergyRadius{0.5, 0},
                                EncircledEnergyRadius{0.9, 1e-3},
                                RingFwhm{},
                                ScatterRms{},
                                SpotFwhm{3e-6},
                                RmsHeight{}};
  const Eigen::VectorXd one = evaluate_exact(scene.input(), all, 1),
                        two = evaluate_exact(scene.input(), all, 2);
  for (Eigen::Index k = 0; k < one.size(); ++k) EXPECT_EQ(one[k], two[k]);
}

TEST(SmoothStatistics, ApproachTheExactOnesWithTheSquareOfTheWidth) {
  const Scene scene = gaussian_scene(1 << 17, 6.3e-6, 3);
  const double sigma = 2 * kF * 6.3e-6;
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.2, 0}, EncircledEnergyRadius{0.5, 0},
                                             EncircledEnergyRadius{0.9, 0},
                                             EncircledEnergyRadius{0.65, 1.5e-3}, RingFwhm{}};
  const Eigen::VectorXd exact = evaluate_exact(scene.input(), statistics, 1);
  Eigen::VectorXd smooth;
  ASSERT_TRUE(evaluate_smooth(scene.input(), statistics, 0.02 * sigma, 1, &smooth, nullptr));
  for (Eigen::Index k = 0; k < exact.size(); ++k)
    EXPECT_NEAR(smooth[k] / exact[k], 1.0, 1.5e-3)
        << k;  // bias 0.02^2/18 = 2e-5; the rest is sampling of the kernel's rays
}

TEST(SmoothStatistics, GradientsMatchDifferencesOfTheSmoothTwin) {
  // Directional derivative along random displacements, fourth-order differences. Ray 0 goes through the axis.
  Scene scene = gaussian_scene(3000, 6e-6, 4, PupilLayout::kRandom);
  const double sigma = 2 * kF * 6e-6, width = 0.3 * sigma;
  scene.rays.x[0] = scene.rays.y[0] = 0;
  scene.rays.x[1] = scene.rays.x[2];  // tied radii
  scene.rays.y[1] = scene.rays.y[2];
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.5, 0},
                                             EncircledEnergyRadius{0.9, 1e-3},
                                             RingFwhm{},
                                             RingFwhm{0.5, 60e-6},
                                             RingThrough{50e-6, 0.7e-3},
                                             ScatterRms{},
                                             ScatterMean{},
                                             SpotFwhm{0.3 * sigma},
                                             RmsRadius{-1e-3},
                                             RmsHeight{}};
  const RandomStream stream(9, "displacement");
  const auto field = [&](std::uint64_t offset, double scale) {
    Eigen::ArrayXd d(scene.rays.size());
    for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = scale * stream.normal(offset + std::uint64_t(i));
    return d;
  };
  const Eigen::ArrayXd dx = field(0, sigma), dy = field(10000, sigma), dtx = field(20000, sigma / kF),
                       dty = field(30000, sigma / kF), dh = field(40000, 1e-7);
  for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
    const auto at = [&](double step) {
      RayBundle rays = scene.rays;
      rays.x += step * dx;
      rays.y += step * dy;
      rays.tx += step * dtx;
      rays.ty += step * dty;
      const Eigen::ArrayXd height = scene.field.height + step * dh;
      Eigen::VectorXd values;
      EXPECT_TRUE(
          evaluate_smooth({rays, scene.nominal, height, centre}, statistics, width, 1, &values, nullptr));
      return values;
    };
    Eigen::VectorXd values;
    std::vector<StatisticGradient> gradients;
    ASSERT_TRUE(evaluate_smooth({scene.rays, scene.nominal, scene.field.height, centre}, statistics, width, 2,
                                &values, &gradients));
    const double step = 2e-4;
    const Eigen::VectorXd difference =
        (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      const StatisticGradient& g = gradients[k];
      double sum = 0;
      const auto component = [](const std::vector<double>& d, std::size_t j) {
        return d.empty() ? 0.0 : d[j];
      };
      const std::size_t entries = g.rays.all_rays ? std::size_t(scene.rays.size()) : g.rays.rays.size();
      for (std::size_t j = 0; j < entries; ++j) {
        const auto i = Eigen::Index(g.rays.all_rays ? j : g.rays.rays[j]);
        const double d_x = component(g.rays.d_x, j), d_y = component(g.rays.d_y, j);
        sum += d_x * dx[i] + d_y * dy[i] + (component(g.rays.d_tx, j) + g.rays.dz * d_x) * dtx[i] +
               (component(g.rays.d_ty, j) + g.rays.dz * d_y) * dty[i];
      }
      if (g.d_height.size() > 0) sum += (g.d_height * dh).sum();
      // Truncation where the kernel's third derivative jumps, and rounding of 1e-16/step.
      EXPECT_NEAR(sum, difference[Eigen::Index(k)],
                  2e-6 * std::abs(values[Eigen::Index(k)]) + 2e-5 * std::abs(sum))
          << statistic_name(statistics[k]);
    }
  }
}

TEST(SmoothStatistics, RefuseAFocusWithoutExtent) {
  const PupilSample pupil = make_pupil(CircleAperture{2 * kR, 0}, {PupilLayout::kPolar, 4096, 1});
  const RayBundle rays = trace_nominal(parabola(), pupil);
  const Eigen::ArrayXd height = Eigen::ArrayXd::Zero(rays.size());
  Eigen::VectorXd values;
  for (const Statistic& s : std::vector<Statistic>{EncircledEnergyRadius{0.5, 0}, ScatterRms{}, ScatterMean{},
                                                   RmsHeight{}, RingFwhm{}})
    EXPECT_FALSE(evaluate_smooth({rays, rays, height}, {s}, 1e-6, 1, &values, nullptr)) << statistic_name(s);
}

TEST(FocusStatistics, PolarQuadratureOfAZernikeSurfaceHasConverged) {
  // RMS radius and scatter RMS integrate analytic functions, so twice the rings and spokes agree to 1e-10.
  TermSet terms;
  terms.radius = kR;
  terms.zernike = zernike_modes(2, 12);
  Eigen::VectorXd coefficients(terms.size());
  const RandomStream stream(3, "fixed-zernike-surface");
  for (Eigen::Index j = 0; j < coefficients.size(); ++j)
    coefficients[j] = 5e-8 * stream.normal(std::uint64_t(j));
  const auto values = [&](std::int64_t rays) {
    const PupilSample pupil = make_pupil(CircleAperture{2 * kR, 0}, {PupilLayout::kPolar, rays, 1});
    SurfaceField field;
    SurfaceOperator(terms, pupil.x, pupil.y).apply(coefficients, &field);
    const RayBundle nominal = trace_nominal(parabola(), pupil), bundle = trace(parabola(), pupil, field);
    return evaluate_exact({bundle, nominal, field.height},
                          {RmsRadius{}, RmsRadius{1e-3}, ScatterRms{}, RmsHeight{}}, 1);
  };
  const Eigen::VectorXd coarse = values(16384), fine = values(65536);
  for (Eigen::Index k = 0; k < 4; ++k) EXPECT_NEAR(coarse[k] / fine[k], 1.0, 1e-10) << k;
  // The RMS height has a closed form, because the modes are orthonormal.
  EXPECT_NEAR(fine[3] / coefficients.norm(), 1.0, 1e-12);
}
