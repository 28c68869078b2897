#include <fftw3.h>
#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

#include "aberfit/roughness/random_surface.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "height_between.h"

// Generalised Harvey-Shack against the mean of diffraction patterns of random surfaces, sampled in the
// direction cosines of the focal plane: |transform|^2 of sqrt(dr^2/dp^2) exp(i phase) on a grid of P = f p.

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kLambda = 632.8e-9;
constexpr int kCells = 96, kGrid = 2 * kCells;  // |transform|^2 then holds the whole autocorrelation
constexpr int kDraws = 200;
constexpr double kStandardErrors = 4;
// A grid cell that the edge cuts has the amplitude `cover` and loses cover - cover^2 = 1/6 of its energy on
// average. Hexagon and annulus have up to 1.6 times as many for their area as a circle.
constexpr double kEdge = 1.6 * 4.0 / 6 / kCells;

using Complex = std::complex<double>;

class Transform {
 public:
  Transform() : data(std::size_t(kGrid) * kGrid) {
    auto* raw = reinterpret_cast<fftw_complex*>(data.data());
    plan_ = fftw_plan_dft_2d(kGrid, kGrid, raw, raw, FFTW_FORWARD, FFTW_ESTIMATE);
  }
  Transform(const Transform&) = delete;
  Transform& operator=(const Transform&) = delete;
  ~Transform() { fftw_destroy_plan(plan_); }
  void run() { fftw_execute(plan_); }
  std::vector<Complex> data;

 private:
  fftw_plan plan_;
};

struct Scene {
  Mirror mirror;
  Aperture aperture;
  double dz;
  std::function<double(double, double)> departure = {};
};

// The pupil on a grid of P.
struct Pupil {
  double pitch = 0;
  std::vector<double> x, y, amplitude, phase, path;  // on the mirror; path: phase per height

  explicit Pupil(const Scene& scene) {
    const double f = scene.mirror.focal_length, R = aperture_radius(scene.aperture);
    const double t = R / (2 * f);
    pitch = 2 * R / (1 + t * t) / kCells;
    constexpr int kParts = 8;
    for (int row = 0; row < kCells; ++row)
      for (int column = 0; column < kCells; ++column) {
        const auto on_mirror = [&](double i, double j, double* mx, double* my) {
          const double px = (i - 0.5 * kCells) * pitch, py = (j - 0.5 * kCells) * pitch;
          const double p = std::hypot(px, py) / f, tangent = p >= 1 ? 1 : p / (1 + std::sqrt(1 - p * p));
          *mx = px * (1 + tangent * tangent);  // P = r/(1 + t^2), t = tan(theta/2), p = sin(theta)
          *my = py * (1 + tangent * tangent);
        };
        int inside = 0;
        for (int i = 0; i < kParts; ++i)
          for (int j = 0; j < kParts; ++j) {
            double mx, my;
            on_mirror(column + (i + 0.5) / kParts, row + (j + 0.5) / kParts, &mx, &my);
            inside += aperture_contains(scene.aperture, mx, my, 0);
          }
        double mx, my;
        on_mirror(column + 0.5, row + 0.5, &mx, &my);
        const double r2 = mx * mx + my * my, t2 = r2 / (4 * f * f);
        x.push_back(mx);
        y.push_back(my);
        amplitude.push_back(double(inside) / (kParts * kParts) * std::sqrt(std::pow(1 + t2, 3) / (1 - t2)));
        path.push_back(4 * pi / (kLambda * (1 + t2)));
        const double departure = base_surface(scene.mirror, mx, my).height - r2 / (4 * f) +
                                 (scene.departure ? scene.departure(mx, my) : 0);
        phase.push_back(path.back() * departure +
                        2 * pi / kLambda * scene.dz / (1 + scene.dz / f) * 2 * t2 / (1 + t2));
      }
  }
};

// Weights w of the samples of |transform|^2 such that sum w I / sum I is the energy within `radius`.
std::vector<double> disc_weights(double radius, double pitch, double scale, Transform* transform) {
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = pitch * std::hypot(i < kCells ? i : i - kGrid, j < kCells ? j : j - kGrid) / scale;
      const double kernel =
          x == 0 ? pi * radius * radius : radius * boost::math::cyl_bessel_j(1, 2 * pi * radius * x) / x;
      transform->data[std::size_t(i) * kGrid + std::size_t(j)] = kernel * std::pow(pitch / scale, 2);
    }
  transform->run();
  std::vector<double> weights;
  for (const Complex& value : transform->data) weights.push_back(value.real());
  return weights;
}

void expect_mean_of_draws(const Scene& scene, double g, std::uint64_t seed) {
  const double R = aperture_radius(scene.aperture), scale = kLambda * (scene.mirror.focal_length + scene.dz);
  const RadialPsd psd(GaussianPsd{g * kLambda / (4 * pi), 0.4 * R});
  const GhsOptions options{.departure = scene.departure};
  const GeneralisedHarveyShack waves(psd, scene.mirror, scene.aperture, kLambda, options);
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-16, 0.4 * R}), scene.mirror, scene.aperture,
                                      kLambda, options);
  const MeanSpot spot = waves.at_plane(scene.dz), perfect = smooth.at_plane(scene.dz);
  const Pupil pupil(scene);
  Transform transform;
  std::vector<double> radii;
  std::vector<std::vector<double>> weights;
  for (const double fraction : {0.2, 0.5, 0.8}) {
    radii.push_back(spot.encircled_energy_radius(fraction));
    weights.push_back(disc_weights(radii.back(), pupil.pitch, scale, &transform));
  }
  constexpr int kMap = 128;
  const double map_pitch = 2.2 * R / (kMap - 8);
  const auto shares = [&](const HeightMap* surface) {
    std::fill(transform.data.begin(), transform.data.end(), Complex(0));
    for (std::size_t k = 0; k < pupil.x.size(); ++k) {
      if (pupil.amplitude[k] == 0) continue;
      const double height = surface ? test::height_between(*surface, map_pitch, pupil.x[k], pupil.y[k]) : 0;
      transform.data[(k / kCells) * kGrid + k % kCells] =
          std::polar(pupil.amplitude[k], pupil.phase[k] + pupil.path[k] * height);
    }
    transform.run();
    std::vector<double> inside(radii.size());
    double all = 0;
    for (std::size_t k = 0; k < transform.data.size(); ++k) {
      const double irradiance = std::norm(transform.data[k]);
      all += irradiance;
      for (std::size_t i = 0; i < radii.size(); ++i) inside[i] += irradiance * weights[i][k];
    }
    for (double& one : inside) one /= all;
    return inside;
  };
  const std::vector<double> reference = shares(nullptr);
  std::vector<double> sum(radii.size()), squares(radii.size());
  for (int draw = 0; draw < kDraws; ++draw) {
    RandomSurfaceOptions draw_options;
    draw_options.seed = seed + std::uint64_t(draw);
    draw_options.oversize = 3;
    const HeightMap surface = random_surface(psd, kMap, kMap, map_pitch, draw_options);
    const std::vector<double> inside = shares(&surface);
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const double change = inside[i] - reference[i];
      sum[i] += change;
      squares[i] += change * change;
    }
  }
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double mean = sum[i] / kDraws;
    const double error = std::sqrt((squares[i] / kDraws - mean * mean) / (kDraws - 1));
    EXPECT_NEAR(mean, spot.encircled_energy(radii[i]) - perfect.encircled_energy(radii[i]),
                kStandardErrors * error)
        << "radius " << radii[i];
    EXPECT_NEAR(reference[i], perfect.encircled_energy(radii[i]), kEdge) << "radius " << radii[i];
  }
}

PolygonAperture hexagon(double radius) {
  PolygonAperture result;
  for (int k = 0; k < 6; ++k)
    result.vertices.push_back({radius * std::cos(k * pi / 3), radius * std::sin(k * pi / 3)});
  return result;
}

}  // namespace

TEST(GhsPupilEnsemble, OfASphere) {
  // f/1.5; the sag differs from the parabola by 0.9 um at the rim.
  expect_mean_of_draws({{4.8e-3, 0, {}}, CircleAperture{3.2e-3}, 0}, 1.0, 100);
}

TEST(GhsPupilEnsemble, OfASphereNearItsBestFocus) {
  expect_mean_of_draws({{4.8e-3, 0, {}}, CircleAperture{3.2e-3}, -12e-6}, 1.0, 400);
}

TEST(GhsPupilEnsemble, OfADefocusedAnnulus) {
  // f/2, one and a half waves of defocus.
  expect_mean_of_draws({{0.8, -1, {}}, AnnulusAperture{0.4, 0.15}, 3 * kLambda * 8}, 1.0, 700);
}

TEST(GhsPupilEnsemble, OfAHexagon) { expect_mean_of_draws({{0.8, -1, {}}, hexagon(0.2), 0}, 1.0, 1000); }

TEST(GhsPupilEnsemble, OfADefocusedHexagonWithHighPowers) {
  expect_mean_of_draws({{0.8, -1, {2e-4, 0, 0, 0, 0}}, hexagon(0.2), 20e-6}, 0.7, 1300);
}

TEST(GhsPupilEnsemble, OfComaAndAstigmatism) {
  const double R = 0.2;
  const auto departure = [R](double x, double y) {
    const double u = x / R, v = y / R;
    return 90e-9 * u * (3 * (u * u + v * v) - 2) + 70e-9 * (u * u - v * v);
  };
  expect_mean_of_draws({{0.8, -1, {}}, CircleAperture{2 * R}, 0, departure}, 0.7, 1600);
}
