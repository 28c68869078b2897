#include "aberfit/theory/convolved_focus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/terms/modal_covariance.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

const Mirror kParabola{2.8, -1, {}};
constexpr double kDiameter = 0.4;
constexpr double kLambda = 632.8e-9;
constexpr double kUnit = kLambda * 2.8 / kDiameter;  // lambda F

double j(int order, double x) { return boost::math::cyl_bessel_j(order, x); }

// Airy's closed form: light within `radius` of the centre of the pattern.
double airy(double radius) {
  const double z = pi * radius / kUnit;
  return 1 - j(0, z) * j(0, z) - j(1, z) * j(1, z);
}

// Light of a pattern about a point at `distance` within `radius` of the axis: rings about the point, each
// with the part of its circumference that lies inside.
double off_axis(double radius, double distance) {
  const auto ring = [&](double rho) {
    const double z = pi * rho / kUnit, airy_slope = z > 0 ? 2 * j(1, z) * j(1, z) / z : 0.0;
    double inside = 0;
    if (rho + distance <= radius)
      inside = 1;
    else if (std::abs(rho - distance) < radius)
      inside = std::acos(std::clamp(
                   (rho * rho + distance * distance - radius * radius) / (2 * rho * distance), -1.0, 1.0)) /
               pi;
    return airy_slope * pi / kUnit * inside;
  };
  // Ends where rings touch the circle; a cubic clears the square roots there.
  const auto piece = [&](double a, double b) {
    double sum = 0;
    const int panels = 4 + int((b - a) / kUnit);
    for (int p = 0; p < panels; ++p) {
      const Quadrature q = gauss_legendre(24, double(p) / panels, double(p + 1) / panels);
      for (Eigen::Index k = 0; k < q.nodes.size(); ++k) {
        const double t = q.nodes[k];
        sum += q.weights[k] * 6 * t * (1 - t) * (b - a) * ring(a + (b - a) * t * t * (3 - 2 * t));
      }
    }
    return sum;
  };
  const double first = std::abs(radius - distance), last = radius + distance;
  return piece(0, first) + piece(first, last);
}

// Rays with positions of the order of `size` [m] in the focus and slopes of a converging beam.
RayBundle some_rays(Eigen::Index count, double size, std::uint64_t seed) {
  const Eigen::VectorXd draw = draw_white(5 * count, seed);
  RayBundle rays;
  rays.x = size * draw.segment(0, count).array();
  rays.y = 0.7 * size * draw.segment(count, count).array() + 0.3 * size;
  rays.tx = 0.04 * draw.segment(2 * count, count).array();
  rays.ty = 0.04 * draw.segment(3 * count, count).array();
  rays.weight = 1 + 0.5 * draw.segment(4 * count, count).array().sin();
  rays.weight /= rays.weight.sum();
  return rays;
}

// Central differences extrapolated to step 0 (Ridders 1982).
double ridders(const std::function<double(double)>& f, double step) {
  constexpr int kRows = 8;
  double table[kRows][kRows], best = 0, error = 1e300;
  for (int i = 0; i < kRows; ++i, step /= 1.6) {
    table[0][i] = (f(step) - f(-step)) / (2 * step);
    double factor = 1.6 * 1.6;
    for (int m = 1; m <= i; ++m, factor *= 1.6 * 1.6) {
      table[m][i] = (table[m - 1][i] * factor - table[m - 1][i - 1]) / (factor - 1);
      const double estimate =
          std::max(std::abs(table[m][i] - table[m - 1][i]), std::abs(table[m][i] - table[m - 1][i - 1]));
      if (estimate < error) {
        error = estimate;
        best = table[m][i];
      }
    }
  }
  return best;
}

}  // namespace

TEST(AperturePattern, SharesOfThePatternMatchAirysIntegralAboutTheAxisAndBesideIt) {
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  constexpr double kBound = 1e-9;  // the header's
  for (const double radius : {0.1, 0.6, 1.22, 3.0, 20.0}) {
    EXPECT_NEAR(pattern.share(radius * kUnit, 0), airy(radius * kUnit), kBound);
    for (const double distance : {0.05, 0.6, 1.5, 2.9, 3.1, 8.0, 40.0})
      EXPECT_NEAR(pattern.share(radius * kUnit, distance * kUnit), off_axis(radius * kUnit, distance * kUnit),
                  kBound)
          << radius << " " << distance;
  }
  // The pattern grows with the distance from the mirror.
  EXPECT_NEAR(pattern.share(2.9 / 2.8 * kUnit, 0, 0.1), airy(kUnit), kBound);
}

TEST(ConvolvedPlane, EnergiesAreSumsOfThePatternsOverRays) {
  constexpr double kBound = 1e-8;  // the header's
  double worst = 0;
  for (const Aperture& aperture :
       {Aperture(CircleAperture{kDiameter}), Aperture(AnnulusAperture{kDiameter, 0.15}),
        Aperture(RectangleAperture{0.3, 0.4})}) {
    const AperturePattern pattern(aperture, 2.8, kLambda);
    for (const double size : {0.01, 0.5, 4.0, 30.0}) {
      const RayBundle rays = some_rays(60, size * kUnit, 7);
      for (const double dz : {0.0, 2e-4}) {
        const ConvolvedPlane plane(pattern, rays, dz);
        for (const double radius : {0.3, 1.0, 2.5, 12.0, 50.0}) {
          double sum = 0;
          for (Eigen::Index i = 0; i < rays.size(); ++i)
            sum += rays.weight[i] *
                   pattern.share(radius * kUnit,
                                 std::hypot(rays.x[i] + dz * rays.tx[i], rays.y[i] + dz * rays.ty[i]), dz);
          worst = std::max(worst, std::abs(plane.energy(radius * kUnit) - sum));
          EXPECT_NEAR(plane.energy(radius * kUnit), sum, kBound);
          const double density =
              ridders([&](double d) { return plane.energy(radius * kUnit + d); }, 0.02 * kUnit);
          EXPECT_NEAR(plane.density(radius * kUnit) * kUnit, density * kUnit, kBound);
        }
      }
    }
  }
  RecordProperty("worst_in_1e-12", int(1e12 * worst));
}

TEST(ConvolvedFocus, APerfectMirrorHasTheRadiiOfAirysPattern) {
  RayBundle point = some_rays(1, 0, 3);
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  Eigen::VectorXd values;
  std::vector<RayGradient> gradients;
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.95, 0}};
  ASSERT_TRUE(evaluate_convolved(pattern, point, statistics, 1, &values, &gradients));
  EXPECT_NEAR(airy(values[0]), 0.5, 1e-9);
  EXPECT_NEAR(airy(values[1]), 0.95, 1e-9);
  EXPECT_EQ(gradients[0].d_x[0], 0);
}

TEST(ConvolvedFocus, PatternsFarSmallerThanTheSpotLeaveTheRays) {
  // The pattern widens radii by its halo: of a share p of the light at radius R, 2/(pi^2 R/(lambda F)) lies
  // further out.
  const RayBundle rays = some_rays(20000, 90 * kUnit, 11);
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  Eigen::VectorXd spread;
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.3, 0}, EncircledEnergyRadius{0.5, 0},
                                          EncircledEnergyRadius{0.8, 1e-3}, RingThrough{90 * kUnit, 1e-3}};
  ASSERT_TRUE(evaluate_convolved(pattern, rays, statistics, 1, &spread, nullptr));
  const Eigen::VectorXd plain = evaluate_exact({rays, rays, rays.x}, statistics, 1);
  const double halo = 2 / (pi * pi * 60);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(spread[k] / plain[k], 1, 2 * halo) << k;
}

TEST(ConvolvedFocus, GradientsMatchDifferencesOfTheValues) {
  const AperturePattern pattern(AnnulusAperture{kDiameter, 0.1}, 2.8, kLambda);
  constexpr double kPrecision = 1e-7;  // differences of values that err by 1e-9 of a step
  for (const double size : {0.3, 3.0}) {
    const RayBundle rays = some_rays(40, size * kUnit, 5);
    const double dz = 20 * size * kUnit;
    const std::vector<Statistic> statistics{EncircledEnergyRadius{0.2, 0},
                                            EncircledEnergyRadius{0.8, 0},
                                            EncircledEnergyRadius{0.5, dz},
                                            RingThrough{size * kUnit, -dz},
                                            RingFwhm{0.8, {}},
                                            RingFwhm{0.9, 2 * size * kUnit}};
    Eigen::VectorXd values;
    std::vector<RayGradient> gradients;
    ASSERT_TRUE(evaluate_convolved(pattern, rays, statistics, 2, &values, &gradients));
    const RayBundle way = some_rays(40, 1, 6);
    const auto moved = [&](double t) {
      RayBundle result = rays;
      result.x += t * kUnit * way.x;
      result.y += t * kUnit * way.y;
      result.tx += t * 0.03 * way.tx;
      result.ty += t * 0.03 * way.ty;
      return result;
    };
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      const RayGradient& g = gradients[k];
      double expected = 0;
      for (std::size_t i = 0; i < 40; ++i) {
        const auto at = Eigen::Index(i);
        const double slope_x = (g.d_tx.empty() ? 0 : g.d_tx[i]) + g.dz * g.d_x[i];
        const double slope_y = (g.d_ty.empty() ? 0 : g.d_ty[i]) + g.dz * g.d_y[i];
        expected += kUnit * (g.d_x[i] * way.x[at] + g.d_y[i] * way.y[at]) +
                    0.03 * (slope_x * way.tx[at] + slope_y * way.ty[at]);
      }
      const double differenced = ridders(
          [&](double t) {
            Eigen::VectorXd there;
            evaluate_convolved(pattern, moved(t), {statistics[k]}, 1, &there, nullptr);
            return there[0];
          },
          0.05);
      EXPECT_NEAR(expected / differenced, 1, kPrecision) << statistic_name(statistics[k]) << " size " << size;
    }
  }
}

TEST(ConvolvedFocus, MeansOfManySurfacesAreThoseOfTheRaysTransferFunction) {
  // Many plane waves of random phase: a stationary surface with Gaussian slopes.
  const RadialPsd psd(UniformPsd{90e-9, 20, 60});
  const Aperture aperture = CircleAperture{kDiameter};
  TermSet terms;
  terms.fourier = fourier_modes(psd, 150, FourierSampling::kLog, 4);
  terms.radius = 0.2;
  const PupilSample pupil = make_pupil(aperture, {PupilLayout::kPolar, 3000, 1});
  const SurfaceOperator surface(terms, pupil, {});
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  GhsOptions options;
  options.surface = SurfaceModel::kRays;
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda, options);
  const AperturePattern pattern(aperture, 2.8, kLambda);
  constexpr int kDraws = 150;
  constexpr double kStandardErrors = 4;
  // In focus the same; out of focus the pattern of the focus stands for that of the defocused wave front,
  // which costs up to this share of the light.
  constexpr double kDefocus = 0.01;
  for (const double dz : {0.0, 2e-4, 1e-3}) {
    const MeanSpot spot = mean.at_plane(dz);
    std::vector<double> radii, sum(4), squares(4);
    for (const double fraction : {0.2, 0.5, 0.8, 0.95})
      radii.push_back(spot.encircled_energy_radius(fraction));
    for (int draw = 0; draw < kDraws; ++draw) {
      SurfaceField field;
      surface.apply(prior.colour(draw_white(prior.size(), std::uint64_t(100 + draw))), &field);
      const RayBundle rays = trace(kParabola, pupil, field);
      const ConvolvedPlane plane(pattern, rays, dz);
      for (std::size_t i = 0; i < radii.size(); ++i) {
        const double energy = plane.energy(radii[i]);
        sum[i] += energy;
        squares[i] += energy * energy;
      }
    }
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const double average = sum[i] / kDraws;
      const double error = std::sqrt((squares[i] / kDraws - average * average) / (kDraws - 1));
      const double expected = spot.encircled_energy(radii[i]);
      EXPECT_NEAR(average, expected, kStandardErrors * error + (dz == 0 ? 0 : kDefocus)) << dz << " " << i;
      RecordProperty("dz" + std::to_string(int(1e6 * dz)) + "_" + std::to_string(i),
                     std::to_string(average - expected) + " +- " + std::to_string(error));
    }
  }
}

TEST(ConvolvedFocus, TheRingWidthIsThatOfAFineScan) {
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  const RayBundle rays = some_rays(300, 3 * kUnit, 5);
  const double ring = 6 * kUnit;
  Eigen::VectorXd values;
  ASSERT_TRUE(evaluate_convolved(pattern, rays, {RingFwhm{0.9, ring}}, 1, &values, nullptr));
  std::vector<double> energy;
  const double step = values[0] / 400;
  for (int k = -400; k <= 400; ++k) energy.push_back(ConvolvedPlane(pattern, rays, k * step).energy(ring));
  const double half = 0.5 * *std::max_element(energy.begin(), energy.end());
  const auto above = std::count_if(energy.begin(), energy.end(), [half](double e) { return e >= half; });
  EXPECT_NEAR(values[0], double(above) * step, step);
}

TEST(ConvolvedFocus, GivesTheSameBitsForAnyThreadCountAndHistory) {
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  const AperturePattern fresh(CircleAperture{kDiameter}, 2.8, kLambda);
  const RayBundle rays = some_rays(3000, 3 * kUnit, 5), wide = some_rays(300, 60 * kUnit, 5);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.2, 0}, EncircledEnergyRadius{0.8, 1e-4},
                                          RingFwhm{}, RingThrough{kUnit, -1e-4}};
  Eigen::VectorXd one, three, other;
  std::vector<RayGradient> of_one, of_three;
  evaluate_convolved(pattern, wide, statistics, 1, &other, nullptr);
  ASSERT_TRUE(evaluate_convolved(pattern, rays, statistics, 1, &one, &of_one));
  ASSERT_TRUE(evaluate_convolved(fresh, rays, statistics, 3, &three, &of_three));
  EXPECT_TRUE(one == three);
  for (std::size_t k = 0; k < statistics.size(); ++k) EXPECT_TRUE(of_one[k].d_x == of_three[k].d_x);
}

TEST(ConvolvedFocus, SaysWhatDoesNotExist) {
  const AperturePattern pattern(CircleAperture{kDiameter}, 2.8, kLambda);
  const RayBundle rays = some_rays(30, 3 * kUnit, 5);
  for (const Statistic& statistic : {Statistic(EncircledEnergyRadius{1.0, 0}), Statistic(RmsRadius{}),
                                     Statistic(ScatterRms{}), Statistic(RingThrough{1.0, 0})}) {
    Eigen::VectorXd values;
    EXPECT_FALSE(evaluate_convolved(pattern, rays, {statistic}, 1, &values, nullptr));
    EXPECT_TRUE(std::isnan(values[0]));
  }
}

TEST(ConvolvedFocus, RefusesPlanesBehindTheMirror) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double focal = 2.8;
  const AperturePattern pattern(CircleAperture{kDiameter}, focal, kLambda);
  const RayBundle rays = some_rays(30, 3 * kUnit, 5);
  for (const double dz : {-focal, -1.5 * focal, std::nan(""), kInfinity, -kInfinity}) {
    EXPECT_FALSE(pattern.has_plane(dz)) << dz;
    EXPECT_TRUE(std::isnan(pattern.share(kUnit, kUnit, dz))) << dz;
    EXPECT_THROW(ConvolvedPlane(pattern, rays, dz), std::invalid_argument) << dz;
    Eigen::VectorXd values;
    EXPECT_FALSE(evaluate_convolved(
        pattern, rays,
        {EncircledEnergyRadius{0.5, dz}, RingThrough{3 * kUnit, dz}, EncircledEnergyRadius{0.5, 0}}, 1,
        &values, nullptr));
    EXPECT_TRUE(std::isnan(values[0]) && std::isnan(values[1]) && values[2] > 0) << dz;
  }
  EXPECT_TRUE(pattern.has_plane(-0.99 * focal));
}
