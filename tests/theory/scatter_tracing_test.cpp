// A pair of terms and scatter function, used as a stray-light program does. Rays reflect at a surface of
// terms and turn by a random angle from the table of the rest. Where the assumptions hold, the energy within
// a radius is that of generalised Harvey-Shack of the whole roughness.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/scatter_function.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

using std::numbers::pi;

// Assumptions: rays may trace the terms, because g is so large (dozens) that the spot is far wider than the
// diffraction pattern. The scatter angle adds to the direction of the reflected ray, because angles are
// small. No frequency is in both parts. `model_error` bounds the first two.
constexpr double kWave = 550e-9, kDiameter = 0.2, kFocalLength = 4;
const Mirror kMirror{kFocalLength};
const Aperture kAperture = CircleAperture{kDiameter};
constexpr std::array<double, 5> kFractions = {0.2, 0.5, 0.8, 0.9, 0.95};

struct Scene {
  std::string name;
  RadialPsd psd;
  double cut;  // [cycles/m]
  RadialPsd low() const { return psd.band(psd.f_min(), cut); }
  RadialPsd rest() const { return psd.band(cut, psd.f_max()); }
};

// 4 to 8000 cycles across.
std::vector<Scene> scenes() {
  return {{"k-correlation", RadialPsd(KCorrelationPsd{3e-6, 0.02, 4.6, 20, 40000}), 3200},
          {"power law", RadialPsd(PowerLawPsd{2.5e-6, {}, 4, 20, 40000}), 1600}};
}

// Random surfaces of a band as terms: plane waves with equal slope variance. One frequency comes from each of
// equal parts of it, and directions turn by golden angles, so every realisation has the slopes of the PSD.
// Amplitudes are normal, so slopes are.
class Surfaces {
 public:
  explicit Surfaces(const RadialPsd& band) {
    const double step = std::log(band.f_max() / band.f_min()) / kSteps;
    for (int k = 0; k <= kSteps; ++k) {
      frequency_.push_back(band.f_min() * std::exp(k * step));
      const double middle = frequency_.back() * std::exp(-0.5 * step);
      variance_.push_back(k == 0 ? 0
                                 : variance_.back() +
                                       std::pow(2 * pi * middle * middle, 2) * 2 * pi * band(middle) * step);
    }
  }
  double slope_variance() const { return variance_.back(); }  // both axes together

  SurfaceField draw(const PupilSample& pupil, const RandomStream& random) const {
    TermSet terms;
    terms.radius = 0.5 * kDiameter;
    Eigen::VectorXd coefficients(2 * kWaves);
    const double share = slope_variance() / kWaves, turn = random.uniform(0);
    for (int j = 0; j < kWaves; ++j) {
      const double f = frequency((j + random.uniform(std::uint64_t(1 + j))) * share);
      const double angle = 2 * pi * (turn + j * (std::numbers::phi - 1));
      terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
      const auto [a, b] = random.normal_pair(std::uint64_t(1 + kWaves + j));
      const double height = std::sqrt(share) / (2 * pi * f);
      coefficients[2 * j] = height * a;
      coefficients[2 * j + 1] = height * b;
    }
    SurfaceField field;
    SurfaceOperator(terms, pupil, {}).apply(coefficients, &field);
    return field;
  }

 private:
  double frequency(double variance) const {
    const auto above = std::upper_bound(variance_.begin() + 1, variance_.end() - 1, variance);
    const auto k = std::size_t(above - variance_.begin());
    const double t = (variance - variance_[k - 1]) / (variance_[k] - variance_[k - 1]);
    return frequency_[k - 1] * std::pow(frequency_[k] / frequency_[k - 1], t);
  }

  static constexpr int kSteps = 4000, kWaves = 128;
  std::vector<double> frequency_, variance_;  // [cycles/m]; variance of the slopes below it
};

// Sine of a random scatter angle, 0 without scatter; tis_within is linear in its square between rows.
double drawn_sine(const ScatterTable& table, double uniform) {
  const double* begin = table.tis_within.data();
  const Eigen::Index rows = table.tis_within.size();
  if (uniform >= table.tis_within[rows - 1]) return 0;
  const Eigen::Index k =
      std::clamp<Eigen::Index>(std::upper_bound(begin, begin + rows, uniform) - begin, 1, rows - 1);
  const double a = std::pow(std::sin(table.theta[k - 1]), 2), b = std::pow(std::sin(table.theta[k]), 2);
  const double span = table.tis_within[k] - table.tis_within[k - 1];
  return std::sqrt(a + (b - a) * (uniform - table.tis_within[k - 1]) / span);
}

// Squares of the distances from the axis at which scattered rays meet the focal plane [m^2].
Eigen::ArrayXd traced(const PupilSample& pupil, const SurfaceField& field, const ScatterTable* table,
                      const RandomStream& random) {
  const RayBundle rays = trace(kMirror, pupil, field);
  EXPECT_EQ(rays.lost, 0);
  Eigen::ArrayXd squares(rays.size());
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const auto [which, azimuth] = random.uniform_pair(std::uint64_t(i));
    const double sine = table ? drawn_sine(*table, which) : 0;
    const double norm = std::sqrt(1 + rays.tx[i] * rays.tx[i] + rays.ty[i] * rays.ty[i]);
    const double l = rays.tx[i] / norm + sine * std::cos(2 * pi * azimuth);
    const double m = rays.ty[i] / norm + sine * std::sin(2 * pi * azimuth);
    const double n = std::sqrt(1 - l * l - m * m);
    const double path = kFocalLength - base_surface(kMirror, pupil.x[i], pupil.y[i]).height - field.height[i];
    squares[i] = std::pow(pupil.x[i] + path * l / n, 2) + std::pow(pupil.y[i] + path * m / n, 2);
  }
  return squares;
}

struct Light {
  Eigen::ArrayXd within, standard_error;  // one per radius; from the means of the realisations
};

// surfaces: null for a mirror without terms. table: null for one that does not scatter.
Light light_within(const std::vector<double>& radii, const Surfaces* surfaces, const ScatterTable* table,
                   int draws) {
  constexpr std::int64_t kRays = 2000;
  Eigen::ArrayXXd share(Eigen::Index(radii.size()), draws);
  parallel_for(std::size_t(draws), available_threads(), [&](std::size_t d) {
    const std::uint64_t seed = 1 + d;
    const PupilSample pupil = make_pupil(kAperture, {PupilLayout::kRandom, kRays, seed});
    SurfaceField field;
    field.height = field.slope_x = field.slope_y = Eigen::ArrayXd::Zero(pupil.size());
    if (surfaces) field = surfaces->draw(pupil, RandomStream(seed, "ScatterTracing terms"));
    const Eigen::ArrayXd squares = traced(pupil, field, table, RandomStream(seed, "ScatterTracing angles"));
    for (std::size_t k = 0; k < radii.size(); ++k)
      share(Eigen::Index(k), Eigen::Index(d)) = (squares <= radii[k] * radii[k]).cast<double>().mean();
  });
  const Eigen::ArrayXd mean = share.rowwise().mean();
  const double n = draws;
  return {mean, ((share.colwise() - mean).square().rowwise().sum() / (n * (n - 1))).sqrt()};
}

// Bound of the error of rays for the energy within r. With u = k s x, k = 4 pi/lambda, s the RMS slope of the
// terms per axis, x the shear and R = r/(2 f s), the energy is R int T J1(uR) du. T of rays is G =
// exp(-u^2/2) times that of the rest, which is below 1. Wave optics has the structure function of the terms.
// By cos a <= 1 - a^2/2 + a^4/24 it subtracts at most eps u^4 from the exponent u^2/2, eps = m4/(24 k^2 s^4),
// m4 = (3/8) int (2 pi f)^4 S d2f. It also has the transfer function of the aperture, at least 1 - (4/pi)
// x/D. Second orders of small angles: (1 + t^2)^2 in the exponent, t = D/4f, and the tangent of the angle for
// its sine.
double model_error(const RadialPsd& low, double radius) {
  const double k = 4 * pi / kWave, s = psd_moments(low).rms_slope_per_axis();
  const double eps = 3.0 / 8 * std::pow(2 * pi, 4) * radial_moment(low, 4) / (24 * k * k * std::pow(s, 4));
  const double ratio = radius / (2 * kFocalLength * s);
  const Quadrature rule = gauss_legendre(400, 0, 12);
  double sum = 0;
  for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
    const double u = rule.nodes[j], quarter = std::min(eps * std::pow(u, 4), 0.5 * u * u);
    const double aperture = std::min(1.0, 4 / pi * u / (k * s * kDiameter));
    sum += rule.weights[j] * std::exp(-0.5 * u * u) * (std::expm1(quarter) + aperture) *
           std::abs(std::cyl_bessel_j(1, u * ratio));
  }
  return ratio * sum + 2 * std::pow(kDiameter / (4 * kFocalLength), 2) +
         0.5 * std::pow(radius / kFocalLength, 2);
}

struct Focus {
  std::vector<double> radii;  // that hold kFractions in generalised Harvey-Shack of the whole [m]
  std::vector<double> model_error;
};

Focus focus_of(const Scene& scene) {
  const GeneralisedHarveyShack whole(scene.psd, kMirror, kAperture, kWave);
  Focus focus;
  for (const double fraction : kFractions) {
    focus.radii.push_back(whole.encircled_energy_radius(fraction, 0));
    focus.model_error.push_back(model_error(scene.low(), focus.radii.back()));
  }
  return focus;
}

// Deviation from generalised Harvey-Shack over the tolerance: four standard errors plus model error.
Eigen::ArrayXd misses(const Focus& focus, const Light& light) {
  Eigen::ArrayXd off(light.within.size());
  for (Eigen::Index i = 0; i < off.size(); ++i)
    off[i] = std::abs(light.within[i] - kFractions[std::size_t(i)]) /
             (4 * light.standard_error[i] + focus.model_error[std::size_t(i)]);
  return off;
}

ScatterTable table_of(const RadialPsd& psd) { return scatter_table(ScatterFunction(psd, kWave)); }

void expect_harvey_shack(const Scene& scene, int draws) {
  SCOPED_TRACE(scene.name);
  const Focus focus = focus_of(scene);
  const Surfaces surfaces(scene.low());
  EXPECT_NEAR(surfaces.slope_variance() / psd_moments(scene.low()).slope_variance, 1, 1e-5);
  const ScatterTable rest = table_of(scene.rest()), all = table_of(scene.psd);
  EXPECT_GT(rest.tis, 0.05);
  EXPECT_LT(rest.tis, 0.5);
  // The bound is small enough to be a test.
  EXPECT_LT(*std::max_element(focus.model_error.begin(), focus.model_error.end()), 0.005);
  // Largest seen: 0.24 of the tolerance.
  const Eigen::ArrayXd pair = misses(focus, light_within(focus.radii, &surfaces, &rest, draws));
  EXPECT_LT(pair.maxCoeff(), 1) << pair.transpose();
  // The cut at the bottom of the band: a perfect mirror that scatters.
  const Eigen::ArrayXd alone = misses(focus, light_within(focus.radii, nullptr, &all, draws));
  EXPECT_LT(alone.maxCoeff(), 1) << alone.transpose();
}

}  // namespace

TEST(ScatterTracing, TermsAndSampledBsdfGiveHarveyShackOfTheWhole) {
  for (const Scene& scene : scenes()) expect_harvey_shack(scene, 200);
}

TEST(ScatterTracing, ScatterOfTheWholeOnTermsCountsThemTwice) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const Focus focus = focus_of(scene);
    const Surfaces surfaces(scene.low());
    const ScatterTable all = table_of(scene.psd);
    // Counting frequencies twice loses 0.08 to 0.24 of the energy within every radius.
    EXPECT_GT(misses(focus, light_within(focus.radii, &surfaces, &all, 100)).minCoeff(), 5);
    // Without the rest there is up to 0.09 too much.
    EXPECT_GT(misses(focus, light_within(focus.radii, &surfaces, nullptr, 200)).maxCoeff(), 2);
  }
}

TEST(FullStatistics, TermsAndSampledBsdfGiveHarveyShackOfTheWhole) {
  for (const Scene& scene : scenes()) expect_harvey_shack(scene, 10000);
}

}  // namespace aberfit
