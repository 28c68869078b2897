// Overlap of a pupil: kernels against formulas in long double, means over direction against a grid.
#include "../../src/theory/pupil_overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "../../src/theory/pupil_kernel.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "regular_polygon.h"
#include "short_form.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

constexpr InstructionSet kSets[] = {InstructionSet::kBaseline, InstructionSet::kAvx2,
                                    InstructionSet::kAvx512};

std::vector<double> random_numbers(int n, double from, double to, unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<double> numbers;
  for (int k = 0; k < n; ++k) numbers.push_back(std::uniform_real_distribution<double>(from, to)(engine));
  return numbers;
}

// Counts that are, and are not, multiples of a vector; rays up to 45 degrees off the axis.
TEST(PupilKernel, PairsAreThoseOfTheFormula) {
  constexpr double kFocal = 1.7, kDefocus = 900;
  for (const int n : {1, 3, 8, 61}) {
    const auto x1 = random_numbers(n, -0.8, 0.8, 1), y1 = random_numbers(n, -0.8, 0.8, 2),
               x2 = random_numbers(n, -0.8, 0.8, 3), y2 = random_numbers(n, -0.8, 0.8, 4);
    for (const InstructionSet set : kSets) {
      if (!is_supported(set)) continue;
      std::vector<double> amplitude(std::size_t(n) + 1, -1), difference(std::size_t(n) + 1, -1);
      parabola_pairs(set, 1 / (kFocal * kFocal), kDefocus,
                     {x1.data(), y1.data(), x2.data(), y2.data(), n, amplitude.data(), difference.data()});
      for (std::size_t k = 0; k < std::size_t(n); ++k) {
        const auto cosine = [](long double x, long double y) {
          return std::sqrt(1 - (x * x + y * y) / (kFocal * kFocal));
        };
        const long double one = cosine(x1[k], y1[k]), two = cosine(x2[k], y2[k]);
        const long double light = 4 / ((1 + one) * (1 + two) * std::sqrt(one * two));
        EXPECT_NEAR(amplitude[k], double(light), 1e-15 * double(light));
        EXPECT_NEAR(difference[k], double(kDefocus * (two - one)), 1e-15 * kDefocus);
      }
      EXPECT_EQ(amplitude.back(), -1);  // not one too many
      EXPECT_EQ(difference.back(), -1);
    }
  }
}

TEST(PupilKernel, MomentsAreSumsOfProductsOfChebyshevPolynomials) {
  constexpr double kOuter = 0.37;
  for (const int n : {1, 5, 64, 1003})
    for (int order = 1; order <= kHighestMomentOrder; ++order) {
      const auto weight = random_numbers(n, -1, 1, 7), radius = random_numbers(n, 0, kOuter, 8),
                 angle = random_numbers(n, 0, 2 * pi, 9);
      std::vector<double> u, v;
      std::vector<long double> truth(std::size_t(order * order), 0);
      for (std::size_t k = 0; k < std::size_t(n); ++k) {
        u.push_back(radius[k] * std::cos(angle[k]));
        v.push_back(radius[k] * std::sin(angle[k]));
        const long double b = std::pow((long double)u[k] / kOuter, 2),
                          a = b + std::pow((long double)v[k] / kOuter, 2);
        const auto polynomial = [](int i, long double t) {
          return std::cos(i * std::acos(std::min(1.0L, std::max(-1.0L, 2 * t - 1))));
        };
        for (int i = 0; i < order; ++i)
          for (int j = 0; j < order; ++j)
            truth[std::size_t(i * order + j)] += weight[k] * polynomial(i, a) * polynomial(j, b);
      }
      for (const InstructionSet set : kSets) {
        if (!is_supported(set)) continue;
        std::vector<double> moment(std::size_t(order * order) + 1, -7);
        chebyshev_moments(set, order, u.data(), v.data(), weight.data(), n, 1 / (kOuter * kOuter),
                          moment.data());
        for (std::size_t k = 0; k < truth.size(); ++k)
          EXPECT_NEAR(moment[k], double(truth[k]), 2e-14 * std::sqrt(n)) << order << ' ' << k;
        EXPECT_EQ(moment.back(), -7);
      }
    }
}

struct Pupil {
  const char* name;
  Aperture aperture;
};
const std::vector<Pupil> kPupils = {
    {"rectangle", RectangleAperture{0.32, 0.18}},
    {"square", RectangleAperture{0.24, 0.24}},
    {"hexagon", test::regular_polygon(6, 0.19, 0.3)},
    {"pentagon", test::regular_polygon(5, 0.2, 0.3)},
    {"triangle", test::regular_polygon(3, 0.2, 0.3)},
    {"quarter", PolygonAperture{{{0, 0}, {0.141, 0}, {0.141, 0.141}, {0, 0.141}}}}};

constexpr double kFocal = 2, kWavelength = 2e-6;
const Mirror kSphere{kFocal, 0, {}};  // three waves at 0.2 m

double sag_of_sphere(double rho) {
  const double radius = 2 * kFocal;
  return rho * rho / (radius + std::sqrt(radius * radius - rho * rho));
}

// The transfer function of a smooth mirror on a grid of shears, each with its own direction, by transforms of
// its pupil. Grid cells count by their fraction inside the aperture.
class OnAGrid {
 public:
  OnAGrid(const PupilField& field, const Aperture& aperture, double dz) {
    const double f = field.focal_length(), wave = 2 * pi / field.wavelength();
    step_ = 2.02 * field.outer() / kCells;
    transfer_.assign(std::size_t(kSide) * kSide, 0);
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        const double px = (i - 0.5 * kCells + 0.5) * step_, py = (j - 0.5 * kCells + 0.5) * step_;
        double inside = 0;
        for (int a = 0; a < kParts; ++a)
          for (int b = 0; b < kParts; ++b) {
            const double qx = px + ((a + 0.5) / kParts - 0.5) * step_,
                         qy = py + ((b + 0.5) / kParts - 0.5) * step_,
                         scale = 2 / (1 + std::sqrt(1 - (qx * qx + qy * qy) / (f * f)));  // r over P
            inside += aperture_contains(aperture, scale * qx, scale * qy, 0) ? 1.0 / (kParts * kParts) : 0;
          }
        const double c = std::sqrt(1 - (px * px + py * py) / (f * f)), rho = 2 * std::hypot(px, py) / (1 + c);
        const double phase =
            wave * ((1 + c) * (sag_of_sphere(rho) - rho * rho / (4 * f)) + dz * (1 - c) / (1 + dz / f));
        const double amplitude = 2 / ((1 + c) * std::sqrt(c));
        transfer_[std::size_t(i * kSide + j)] = std::polar(inside * amplitude, phase);
        light_ += inside * amplitude * amplitude;  // includes energy beyond the grid's view
      }
    const FourierTransform transform(kSide, kSide);
    transform(transfer_.data());
    for (std::complex<double>& one : transfer_) one = std::norm(one);
    transform(transfer_.data());  // symmetric, so forward and inverse agree but for the order
    light_ *= double(kSide) * kSide;
    u_per_radius_ = wave / (f + dz);
  }
  // 1/(2 pi) int OTF(x) u J1(u |x|) / |x| d2x with u of this radius, by Parseval's theorem for a disc.
  double encircled_energy(double radius) const {
    const double u = u_per_radius_ * radius;
    double sum = 0;
    std::vector<double> x(kSide), z(kSide), j0(kSide), j1(kSide);
    for (int i = -kSide / 2; i < kSide / 2; ++i) {
      for (int j = 0; j < kSide; ++j) {
        x[std::size_t(j)] = step_ * std::hypot(i, j - kSide / 2);
        z[std::size_t(j)] = u * x[std::size_t(j)];
      }
      bessel_j0_j1(z.data(), kSide, j0.data(), j1.data());
      for (int j = 0; j < kSide; ++j) {
        const double value = transfer_[at(i) * kSide + at(j - kSide / 2)].real(), far = x[std::size_t(j)];
        sum += value * (far > 0 ? u * j1[std::size_t(j)] / far : 0.5 * u * u);
      }
    }
    return sum * step_ * step_ / (2 * pi * light_);
  }

 private:
  static constexpr int kCells = 600, kSide = 1200, kParts = 8;
  static std::size_t at(int k) { return std::size_t(k < 0 ? k + kSide : k); }
  double step_ = 0, u_per_radius_ = 0, light_ = 0;
  std::vector<std::complex<double>> transfer_;
};

// The error of the grid itself is up to 2.6e-4 and halves with the pitch.
TEST_WITH_SHORT_FORM(PupilLight, OfPolygonsIsThatOfAPlainGrid) {
  const RadialPsd smooth(GaussianPsd{1e-12, 0.01});
  for (const Pupil& one : aberfit::test::all_or_few(whole, kPupils, {2}))
    for (const double dz : {0.0, 8e-3}) {
      const OnAGrid truth(PupilField(kSphere, one.aperture, kWavelength, {}), one.aperture, dz);
      const MeanSpot spot = GeneralisedHarveyShack(smooth, kSphere, one.aperture, kWavelength).at_plane(dz);
      for (const double fraction : {0.3, 0.5, 0.7}) {
        const double radius = spot.encircled_energy_radius(fraction);
        EXPECT_NEAR(truth.encircled_energy(radius), fraction, 3e-4) << one.name << ' ' << dz;
      }
    }
}

}  // namespace
}  // namespace aberfit::internal
