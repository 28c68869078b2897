// Irradiance for the pictures, against closed forms and against itself: an image must hold the encircled
// energy.
#include "aberfit/report/focal_light.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <numbers>

#include "../../src/report/round_image.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kFocalLength = 2.8, kRadius = 0.2, kWavelength = 632.8e-9;
constexpr double kAiryUnit = kWavelength * kFocalLength / (2 * kRadius);  // lambda F

double airy_share(double radius) {
  const double z = std::numbers::pi * radius / kAiryUnit;
  const double j0 = boost::math::cyl_bessel_j(0, z), j1 = boost::math::cyl_bessel_j(1, z);
  return 1 - j0 * j0 - j1 * j1;
}

Eigen::ArrayXd airy_shares(const Eigen::ArrayXd& radii) { return radii.unaryExpr(&airy_share); }

// Energy of an image inside a circle about its centre. Pixels on the edge count by the fraction of 8 x 8
// points inside, as if evenly lit; the error is 0.2 % of the energy where the pattern is steep.
double within(const Eigen::ArrayXXd& image, double half_width, double radius) {
  const Eigen::Index pixels = image.rows();
  const double pixel = 2 * half_width / double(pixels);
  double sum = 0;
  for (Eigen::Index j = 0; j < pixels; ++j) {
    for (Eigen::Index i = 0; i < pixels; ++i) {
      int inside = 0;
      for (int v = 0; v < 8; ++v)
        for (int u = 0; u < 8; ++u)
          inside += std::hypot((double(i) + (u + 0.5) / 8) * pixel - half_width,
                               (double(j) + (v + 0.5) / 8) * pixel - half_width) <= radius;
      sum += image(j, i) * inside / 64;
    }
  }
  return sum;
}

struct TermScene {
  Mirror mirror;
  Aperture aperture = CircleAperture{2 * kRadius, 0};
  FocusModel model;
  PupilSample pupil;
  TermSet terms{kRadius, zernike_modes(2, 6), {}, {}};
  SurfaceOperator surface;
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(terms.size());

  explicit TermScene(FocusModel by, double focal_length = kFocalLength)
      : mirror{focal_length, -1, {}},
        model(by),
        pupil(by == FocusModel::kWaves ? diffraction_pupil(aperture, focal_length, 2 * kRadius / 128).sample
                                       : make_pupil(aperture, {PupilLayout::kSobol, 20000, 3})),
        surface(terms, pupil, {1, {}, {}, by == FocusModel::kWaves}) {}
  LightPath path() const { return {mirror, pupil, surface, model, kWavelength, &aperture}; }
  void roughen() {
    for (Eigen::Index k = 0; k < coefficients.size(); ++k) coefficients[k] = 6e-9 * std::cos(1.7 * double(k));
  }
  std::unique_ptr<FocalLight> light() const { return surface_light(path(), coefficients, 1); }
};

// Energy of the Airy pattern in a square about its middle: that within the edge, averaged over directions.
double airy_share_in_square(double side) {
  const auto at = [&](double angle) { return airy_share(0.5 * side / std::cos(angle)); };
  constexpr double kEighth = std::numbers::pi / 4;
  return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(at, 0.0, kEighth, 12, 1e-12) / kEighth;
}

// Squares of pixels hold what the closed form says, with pixels of a fortieth of lambda F to twenty of it.
TEST(RoundImage, OfTheAiryPatternHoldsItsLight) {
  for (const double pixel : {0.025, 0.3, 1.0, 4.4, 20.0}) {
    for (const int pixels : {33, 34}) {
      const double half = 0.5 * pixels * pixel * kAiryUnit;
      const Eigen::ArrayXXd image = round_image(airy_shares, kAiryUnit, half, pixels);
      for (int inside = 2 - pixels % 2; inside <= pixels; inside += 8) {
        const Eigen::Index first = (pixels - inside) / 2;
        const double found = image.block(first, first, inside, inside).sum();
        const double truth = airy_share_in_square(inside * pixel * kAiryUnit);
        EXPECT_NEAR(found, truth, 2e-6 * std::min(1.0, std::pow(inside * pixel, 2)))
            << pixel << ' ' << pixels << ' ' << inside;
      }
      EXPECT_TRUE((image - image.transpose()).isZero(1e-15));
      EXPECT_TRUE((image - image.colwise().reverse()).isZero(1e-15));
    }
  }
}

// At f/7 the direction cosines of the rim change the Airy pattern by 1e-3 of the energy; at f/70 by 1e-5.
TEST(FocalLight, OfAPerfectMirrorIsTheAiryPattern) {
  constexpr double kLonger = 10, kUnit = kLonger * kAiryUnit, half = 6 * kUnit;
  const Eigen::ArrayXd radii = Eigen::ArrayXd::LinSpaced(25, 0, half);
  const TermScene flat(FocusModel::kWaves, kLonger * kFocalLength);
  const auto light = flat.light();
  EXPECT_LT((light->encircled_energy(radii) - airy_shares(radii / kLonger)).abs().maxCoeff(), 2e-5);
  const Eigen::ArrayXXd image = light->image(0, half, 129);
  for (const double radius : {1.0, 3.0, 5.9})
    EXPECT_NEAR(within(image, half, radius * kUnit), airy_share(radius * kAiryUnit), 2e-3);
  EXPECT_TRUE(std::isinf(light->sample_size()));
}

// Two methods must give the same energy: circles by the transfer function, and pixels of an image.
TEST(FocalLight, ImagesHoldTheLightOfTheirCircles) {
  for (const FocusModel model : {FocusModel::kRays, FocusModel::kWaves}) {
    TermScene rough(model);
    rough.roughen();
    const auto light = rough.light();
    const double half = 3 * light->statistic(EncircledEnergyRadius{0.9, 0.0});
    const double out = 0.3 * half * kFocalLength / kRadius;
    for (const double dz : {0.0, out}) {
      const Eigen::ArrayXXd image = light->image(dz, half, 201);
      for (const double radius : {0.2 * half, 0.5 * half, 0.9 * half}) {
        const double share = light->ring_through(radius, Eigen::ArrayXd::Constant(1, dz))[0];
        // Rays are smeared over pixels, and waves fold a little at the edge of their field of view.
        EXPECT_NEAR(within(image, half, radius), share, 0.01)
            << to_string(model) << ' ' << dz << ' ' << radius;
      }
    }
  }
}

TEST(FocalLight, CurvesMeetTheStatistics) {
  for (const FocusModel model : {FocusModel::kRays, FocusModel::kWaves}) {
    TermScene rough(model);
    rough.roughen();
    const auto light = rough.light();
    const double ee50 = light->statistic(EncircledEnergyRadius{0.5, 0.0});
    EXPECT_NEAR(light->encircled_energy(Eigen::Array2d(0, ee50 * (1 + 1e-9)))[1], 0.5, 1e-4)
        << to_string(model);
    const double width = light->statistic(RingFwhm{0.9, 2 * ee50});
    const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(401, -width, width);
    const Eigen::ArrayXd through = light->ring_through(2 * ee50, planes);
    const double above = double((through >= 0.5 * through.maxCoeff()).count()) * 2 * width / 400;
    EXPECT_NEAR(above / width, 1, 0.02) << to_string(model);
  }
}

// The roughness has 24 cycles across, of which the grid resolves 20.
TEST(FocalLight, CurvesOfManyPlanesHaveTheHaloOfEach) {
  const Mirror parabola{1.6, -1, {}};
  const Aperture circle = CircleAperture{0.2, 0};
  const RadialPsd psd(KCorrelationPsd{75e-9, 0.04, 3.0, 10, 120});  // g 1.5
  const auto whole = std::make_shared<const GeneralisedHarveyShack>(psd, parabola, circle, kWavelength);
  const PupilSample pupil = diffraction_pupil(circle, 1.6, 0.2 / 40).sample;
  const TermSet terms{0.1, zernike_modes(2, 6), {}, {}};
  const SurfaceOperator surface(terms, pupil, {1, {}, {}, true});
  LightPath path{parabola, pupil, surface, FocusModel::kWaves, kWavelength, &circle};
  path.aliased_limit = 0.2;  // far out of focus at the rim
  path.scatter = std::make_shared<const BandSplit>(psd, 30, parabola, circle, kWavelength, whole);
  Eigen::VectorXd coefficients(terms.size());
  for (Eigen::Index k = 0; k < terms.size(); ++k) coefficients[k] = 12e-9 * std::cos(1.7 * double(k));
  const auto light = surface_light(path, coefficients, 2);
  const double ring = whole->encircled_energy_radius(0.3, 0);
  const double width = light->statistic(RingFwhm{0.3, ring});
  const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(81, -width, width);
  const std::vector<Eigen::Index> some = {0, 14, 27, 38, 40, 43, 53, 63, 80};
  const Eigen::ArrayXd curve = light->ring_through(ring, planes),
                       single = light->ring_through(ring, planes(some));
  const double off = (curve(some) - single).abs().maxCoeff();
  RecordProperty("off", std::to_string(off));
  EXPECT_LT(off, 1e-9);
  // Planes whose phase the grid cannot resolve do not disturb the others.
  path.aliased_limit = 1e-3;
  const auto strict = surface_light(path, coefficients, 2);
  const Eigen::ArrayXd wide = strict->ring_through(ring, 10 * planes);
  EXPECT_TRUE(std::isnan(wide[0]) && std::isnan(wide[80]));
  for (const Eigen::Index k : {40, 41})
    EXPECT_NEAR(wide[k], strict->ring_through(ring, Eigen::ArrayXd::Constant(1, 10 * planes[k]))[0], 1e-4)
        << k;
  // The curve must have the printed width.
  const double above = double((curve >= 0.5 * curve.maxCoeff()).count()) * 2 * width / 80;
  EXPECT_NEAR(above / width, 1, 0.02);
}

// A wide spot, of which the grid points see a tenth, a third, or all. Its pixels hold the same energy as
// circles, inside and outside the field of view.
TEST(FocalLight, ImagesHoldTheLightOfTheirCirclesBeyondTheFieldOfView) {
  const Mirror parabola{1.6, -1, {}};
  const Aperture circle = CircleAperture{0.2, 0};
  const RadialPsd psd(UniformPsd{200e-9, 10, 200});
  const auto whole = std::make_shared<const GeneralisedHarveyShack>(psd, parabola, circle, kWavelength);
  const double half = 1.3 * whole->encircled_energy_radius(0.9, 0);
  const TermSet terms{0.1, zernike_modes(2, 6), {}, {}};
  double off = 0;
  for (const double views : {0.1, 0.3, 1.2}) {  // fields of view in the image
    const double pitch = kWavelength * 1.6 / (views * 2 * half);
    const PupilSample pupil = diffraction_pupil(circle, 1.6, pitch).sample;
    const SurfaceOperator surface(terms, pupil, {1, {}, {}, true});
    LightPath path{parabola, pupil, surface, FocusModel::kWaves, kWavelength, &circle};
    path.scatter = std::make_shared<const BandSplit>(psd, 30, parabola, circle, kWavelength, whole);
    Eigen::VectorXd coefficients(terms.size());
    for (Eigen::Index k = 0; k < terms.size(); ++k) coefficients[k] = 12e-9 * std::cos(1.7 * double(k));
    const auto light = surface_light(path, coefficients, 2);
    for (const double dz : {0.0, -0.4 * std::min(light->farthest_plane(), 1.0)}) {
      const Eigen::ArrayXXd image = light->image(dz, half, 129);
      EXPECT_GE(image.minCoeff(), 0);
      for (const double radius : {0.2 * half, 0.5 * half, 0.95 * half}) {
        const double share = light->ring_through(radius, Eigen::ArrayXd::Constant(1, dz))[0];
        const double here = std::abs(within(image, half, radius) - share);
        EXPECT_LT(here, 0.001) << views << ' ' << dz << ' ' << radius / half;
        off = std::max(off, here);
      }
    }
  }
  RecordProperty("off", std::to_string(off));
}

TEST(FocalLight, OfAMeanSpotIsRoundAndHoldsItsLight) {
  Mirror parabola;
  parabola.focal_length = kFocalLength;
  const auto spot = std::make_shared<const GeneralisedHarveyShack>(
      RadialPsd(UniformPsd{50e-9, 2.5, 20}), parabola, CircleAperture{2 * kRadius, 0}, kWavelength);
  const auto light = mean_light(spot, kWavelength * kFocalLength, 2);
  const double half = 2 * spot->encircled_energy_radius(0.9, 0);
  const Eigen::ArrayXXd image = light->image(0, half, 201);
  EXPECT_TRUE((image - image.transpose()).isZero(1e-15));
  for (const double radius : {0.2 * half, 0.6 * half, 0.95 * half})
    EXPECT_NEAR(within(image, half, radius), spot->encircled_energy(radius, 0), 2e-3);
  EXPECT_EQ(light->encircled_energy(Eigen::ArrayXd::Constant(1, half))[0], spot->encircled_energy(half, 0));
  EXPECT_TRUE(std::isnan(light->statistic(RmsRadius{})));
  EXPECT_EQ(light->statistic(EncircledEnergyRadius{0.5, 0.0}), spot->encircled_energy_radius(0.5, 0));
}

}  // namespace
}  // namespace aberfit
