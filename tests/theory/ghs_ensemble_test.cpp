#include <fftw3.h>
#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aberfit/roughness/random_surface.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

const Mirror kParabola{2.8, -1, {}};
constexpr double kDiameter = 0.4;
constexpr double kLambda = 632.8e-9;
constexpr int kCells = 96;         // across the diameter
constexpr int kGrid = 2 * kCells;  // |transform|^2 then holds the whole autocorrelation
constexpr double kPitch = kDiameter / kCells;
constexpr int kDraws = 200;
constexpr double kStandardErrors = 4;
// The edge cuts pi N of pi N^2/4 grid cells. A cut cell with the amplitude `cover` loses cover - cover^2 =
// 1/6 of its energy on average, which changes the rim's part of the pattern by as much.
constexpr double kEdge = 4.0 / 6 / kCells;

using Complex = std::complex<double>;

// Square complex transform, in place.
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

double position(int cell) { return (cell + 0.5 - 0.5 * kCells) * kPitch; }

// Fraction of each grid cell inside the circle.
std::vector<double> circle_cover() {
  std::vector<double> cover(std::size_t(kCells) * kCells);
  constexpr int kParts = 16;
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column)
      for (int i = 0; i < kParts; ++i)
        for (int j = 0; j < kParts; ++j) {
          const double x = position(column) + ((j + 0.5) / kParts - 0.5) * kPitch;
          const double y = position(row) + ((i + 0.5) / kParts - 0.5) * kPitch;
          if (std::hypot(x, y) <= 0.5 * kDiameter)
            cover[std::size_t(row) * kCells + std::size_t(column)] += 1.0 / (kParts * kParts);
        }
  return cover;
}

// Weights w of the samples of |transform|^2 such that sum w I / sum I is the energy within `radius`: the
// transform of r J1(2 pi r x/(lambda f)) / (x/(lambda f)) over the shears x.
std::vector<double> disc_weights(double radius, Transform* transform) {
  const double scale = kLambda * kParabola.focal_length;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = kPitch * std::hypot(i < kCells ? i : i - kGrid, j < kCells ? j : j - kGrid) / scale;
      const double kernel =
          x == 0 ? pi * radius * radius : radius * boost::math::cyl_bessel_j(1, 2 * pi * radius * x) / x;
      transform->data[std::size_t(i) * kGrid + std::size_t(j)] = kernel * std::pow(kPitch / scale, 2);
    }
  transform->run();
  std::vector<double> weights;
  for (const Complex& value : transform->data) weights.push_back(value.real());
  return weights;
}

}  // namespace

TEST_WITH_SHORT_FORM(GhsEnsemble, MeanOfTwoHundredDiffractionPatternsAgrees) {
  const RadialPsd gaussian(GaussianPsd{1, 0.04}), uniform(UniformPsd{1, 5, 30}),
      fractal(KCorrelationPsd{1, 0.2, 4.5, 0, 100});
  struct Case {
    double g;
    RadialPsd psd;
  };
  const std::vector<Case> cases = {{0.1, gaussian}, {0.2, uniform}, {0.35, fractal}, {0.5, gaussian},
                                   {0.75, uniform}, {1.0, fractal}, {1.5, gaussian}, {2.0, uniform},
                                   {3.0, fractal},  {5.0, gaussian}};
  const std::vector<double> cover = circle_cover();
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-16, 0.04}), kParabola,
                                      CircleAperture{kDiameter}, kLambda);
  Transform transform;
  std::uint64_t seed = 0;
  double worst = 0;
  for (const Case& one : aberfit::test::all_or_few(whole, cases, {2, 7})) {
    const RadialPsd psd = one.psd.scaled(one.g * kLambda / (4 * pi));
    const GeneralisedHarveyShack waves(psd, kParabola, CircleAperture{kDiameter}, kLambda);
    const MeanSpot spot = waves.at_plane(0), perfect = smooth.at_plane(0);
    std::vector<double> radii;
    std::vector<std::vector<double>> weights;
    for (const double fraction : {0.3, 0.6, 0.85}) {
      radii.push_back(spot.encircled_energy_radius(fraction));
      weights.push_back(disc_weights(radii.back(), &transform));
    }
    // Energies of one surface, or (draw < 0) of the perfect aperture, which has the same staircase edge.
    const auto shares = [&](int draw) {
      HeightMap surface;
      if (draw >= 0) {
        RandomSurfaceOptions options;
        options.seed = ++seed;
        options.oversize = 3;
        surface = random_surface(psd, kCells, kCells, kPitch, options);
      }
      std::fill(transform.data.begin(), transform.data.end(), Complex(0));
      for (int row = 0; row < kCells; ++row)
        for (int column = 0; column < kCells; ++column)
          transform.data[std::size_t(row) * kGrid + std::size_t(column)] =
              std::polar(cover[std::size_t(row) * kCells + std::size_t(column)],
                         draw < 0 ? 0.0 : 4 * pi / kLambda * surface.height(row, column));
      transform.run();
      std::vector<double> inside(radii.size());
      double all = 0;
      for (std::size_t k = 0; k < transform.data.size(); ++k) {
        const double irradiance = std::norm(transform.data[k]);
        all += irradiance;
        for (std::size_t i = 0; i < radii.size(); ++i) inside[i] += irradiance * weights[i][k];
      }
      for (double& share : inside) share /= all;
      return inside;
    };
    const std::vector<double> reference = shares(-1);
    std::vector<double> sum(radii.size()), squares(radii.size());
    for (int draw = 0; draw < kDraws; ++draw) {
      const std::vector<double> inside = shares(draw);
      for (std::size_t i = 0; i < radii.size(); ++i) {
        const double change = inside[i] - reference[i];
        sum[i] += change;
        squares[i] += change * change;
      }
    }
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const double mean = sum[i] / kDraws;
      const double error = std::sqrt((squares[i] / kDraws - mean * mean) / (kDraws - 1));
      const double expected = spot.encircled_energy(radii[i]) - perfect.encircled_energy(radii[i]);
      EXPECT_NEAR(mean, expected, kStandardErrors * error) << "g " << one.g << " radius " << radii[i];
      EXPECT_NEAR(reference[i], perfect.encircled_energy(radii[i]), kEdge);
      worst = std::max(worst, std::abs(mean - expected) / error);
    }
  }
  RecordProperty("worst_in_hundredths_of_standard_errors", int(100 * worst));
}
