// Known Zernikes of the mirror against textbook forms and closed forms of the foci, in all of `trace`.
#include "aberfit/trace/nominal_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "aberfit/core/random.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/trace/central_difference.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2.8, kRadius = 0.21;

// Orthonormal Zernikes 1 to 11 by Noll's index in Cartesian form, x and y over the radius (Noll 1976, table
// 1, with rho cos theta = x and rho sin theta = y).
double noll(int j, double x, double y) {
  const double r2 = x * x + y * y;
  switch (j) {
    case 1:
      return 1;
    case 2:
      return 2 * x;
    case 3:
      return 2 * y;
    case 4:
      return std::sqrt(3.0) * (2 * r2 - 1);
    case 5:
      return std::sqrt(6.0) * 2 * x * y;
    case 6:
      return std::sqrt(6.0) * (x * x - y * y);
    case 7:
      return std::sqrt(8.0) * (3 * r2 - 2) * y;
    case 8:
      return std::sqrt(8.0) * (3 * r2 - 2) * x;
    case 9:
      return std::sqrt(8.0) * (3 * x * x * y - y * y * y);
    case 10:
      return std::sqrt(8.0) * (x * x * x - 3 * x * y * y);
    default:
      return std::sqrt(5.0) * (6 * r2 * r2 - 6 * r2 + 1);
  }
}

Mirror mirror_with(std::initializer_list<std::pair<int, double>> heights, double conic = -1) {
  Mirror mirror{kFocal, conic, {}};
  mirror.zernike_radius = kRadius;
  for (const auto& [j, height] : heights) mirror.zernike.push_back({zernike_from_noll(j), height});
  return mirror;
}

const std::initializer_list<std::pair<int, double>> kAll = {{1, 40e-9}, {2, -20e-9}, {3, 70e-9},  {4, 120e-9},
                                                            {5, 35e-9}, {6, -90e-9}, {7, -30e-9}, {8, 55e-9},
                                                            {9, 15e-9}, {10, 25e-9}, {11, -60e-9}};

// Every layout with its own structure, and shapes with corners.
std::vector<PupilSample> pupils() {
  return {make_pupil(CircleAperture{2 * kRadius}, {PupilLayout::kPolar, 2000, 1}),
          make_pupil(RectangleAperture{0.34, 0.24}, {PupilLayout::kGrid, 2000, 1}),
          make_pupil(AnnulusAperture{0.4, 0.1}, {PupilLayout::kSobol, 1500, 1})};
}

SurfaceField rough_field(Eigen::Index n, double slope) {
  SurfaceField field;
  field.resize(n);
  const RandomStream stream(11, "nominal-surface-test");
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    field.slope_x[i] = slope * a;
    field.slope_y[i] = slope * b;
    field.height[i] = 1e-3 * slope * stream.normal(std::uint64_t(2 * i + 1));
  }
  return field;
}

TEST(NominalSurface, HeightsAreThoseOfTheTextbookForms) {
  const Mirror mirror = mirror_with(kAll);
  for (const PupilSample& pupil : pupils()) {
    const SurfaceField field = known_zernike_field(mirror, pupil);
    const Eigen::ArrayXd departure = departure_from_parabola(mirror, pupil);
    for (Eigen::Index i = 0; i < pupil.size(); ++i) {
      const double x = pupil.x[i], y = pupil.y[i];
      double expected = 0;
      for (const auto& [j, height] : kAll) expected += height * noll(j, x / kRadius, y / kRadius);
      constexpr double kRounding = 1e-12 * 1e-6;  // for heights up to 1 um
      EXPECT_NEAR(field.height[i], expected, kRounding);
      EXPECT_NEAR(departure[i], expected, kRounding);
      const double sag = base_surface(mirror, x, y).height, parabola = (x * x + y * y) / (4 * kFocal);
      EXPECT_NEAR(sag - parabola, expected, kRounding + 4e-16 * sag);
    }
  }
}

// A step along the imaginary axis gives the derivative of an analytic function to rounding.
TEST(NominalSurface, SlopesAreTheDerivativesOfTheHeightsOfAnySag) {
  Mirror mirror = mirror_with(kAll, -0.3);
  mirror.spherical = {1e-6, 0, -2e-5, 0, 1e-4};
  mirror.zernike.push_back({{20, -14}, 80e-9});
  mirror.zernike.push_back({{33, 1}, 5e-9});
  using Complex = std::complex<double>;
  constexpr double kStep = 1e-40;
  const PupilSample pupil = pupils().back();
  const SurfaceField field = known_zernike_field(mirror, pupil);
  for (Eigen::Index i = 0; i < pupil.size(); i += 7) {
    const double x = pupil.x[i], y = pupil.y[i];
    const SurfacePoint<double> point = base_surface(mirror, x, y);
    const double along_x = base_surface(mirror, Complex(x, kStep), Complex(y)).height.imag() / kStep;
    const double along_y = base_surface(mirror, Complex(x), Complex(y, kStep)).height.imag() / kStep;
    EXPECT_NEAR(point.slope_x, along_x, 1e-15);
    EXPECT_NEAR(point.slope_y, along_y, 1e-15);
    const SurfacePoint<double> rest = base_surface(without_known_zernikes(mirror), x, y);
    EXPECT_NEAR(field.slope_x[i], point.slope_x - rest.slope_x, 1e-15);
    EXPECT_NEAR(field.slope_y[i], point.slope_y - rest.slope_y, 1e-15);
  }
}

TEST(NominalSurface, TellsWhichMirrorsAreParabolasAndWhichAreOfRevolution) {
  EXPECT_TRUE(is_parabola(mirror_with({})));
  EXPECT_TRUE(is_parabola(mirror_with({{4, 0.0}, {5, 0.0}})));
  EXPECT_FALSE(is_parabola(mirror_with({{4, 1e-12}})));
  EXPECT_FALSE(is_parabola(mirror_with({}, 0)));
  EXPECT_TRUE(is_rotationally_symmetric(mirror_with({{4, 1e-7}, {11, 1e-7}, {5, 0.0}}, 0)));
  EXPECT_FALSE(is_rotationally_symmetric(mirror_with({{4, 1e-7}, {2, 1e-7}})));
  EXPECT_TRUE(departure_from_parabola(mirror_with({}), pupils()[0]).size() == 0);
}

// At f/0.6 the first term of the series has an error of a tenth. The reference is the sag of the circle.
TEST(NominalSurface, DepartureOfAFastSphereIsThatOfItsCircle) {
  using Real = long double;
  Mirror sphere;
  sphere.focal_length = 0.25;
  sphere.conic = 0;
  const PupilSample pupil = make_pupil(CircleAperture{2 * kRadius}, {PupilLayout::kRandom, 200, 1});
  const Eigen::ArrayXd departure = departure_from_parabola(sphere, pupil);
  ASSERT_EQ(departure.size(), pupil.size());
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const Real x = pupil.x[i], y = pupil.y[i], rho2 = x * x + y * y;
    const Real circle = 0.5L - std::sqrt(0.25L - rho2);       // radius of curvature 0.5 m
    EXPECT_NEAR(departure[i], double(circle - rho2), 1e-16);  // rho^2/(4 f) with 4 f = 1 m
  }
}

// Z4 turns the mirror into another parabola, 1/(4f') = 1/(4f) + 2 sqrt(3) a/R^2, moved by -sqrt(3) a.
TEST(NominalSurface, KnownDefocusMovesTheFocusToThatOfTheOtherParabola) {
  for (const double a : {120e-9, -3e-6}) {
    const double inverse = 1 / (4 * kFocal) + 2 * std::sqrt(3.0) * a / (kRadius * kRadius);
    const double focus = 1 / (4 * inverse) - std::sqrt(3.0) * a;
    const PupilSample pupil = pupils()[0];
    const RayBundle rays = trace_nominal(mirror_with({{4, a}}), pupil);
    EXPECT_GT(Eigen::abs(rays.x).maxCoeff(), 1e-7);  // the rays miss the old focus
    EXPECT_LT(Eigen::abs(rays.x + (focus - kFocal) * rays.tx).maxCoeff(), 1e-14);
    EXPECT_LT(Eigen::abs(rays.y + (focus - kFocal) * rays.ty).maxCoeff(), 1e-14);
  }
}

// Z6 bends the two sections along the axes into parabolas of different focal lengths.
TEST(NominalSurface, KnownAstigmatismHasItsTwoFoci) {
  constexpr double kHeight = 250e-9;
  const double more = std::sqrt(6.0) * kHeight / (kRadius * kRadius);
  PupilSample pupil;
  pupil.x = Eigen::ArrayXd::LinSpaced(40, -0.2, 0.2);
  pupil.y = Eigen::ArrayXd::Zero(40);
  pupil.weight = Eigen::ArrayXd::Constant(40, 1.0 / 40);
  const Mirror mirror = mirror_with({{6, kHeight}});
  const double along_x = 1 / (4 * (1 / (4 * kFocal) + more)), along_y = 1 / (4 * (1 / (4 * kFocal) - more));
  const RayBundle rays = trace_nominal(mirror, pupil);
  EXPECT_LT(Eigen::abs(rays.x + (along_x - kFocal) * rays.tx).maxCoeff(), 1e-14);
  pupil.x.swap(pupil.y);
  const RayBundle other = trace_nominal(mirror, pupil);
  EXPECT_LT(Eigen::abs(other.y + (along_y - kFocal) * other.ty).maxCoeff(), 1e-14);
  EXPECT_GT(Eigen::abs(other.y + (along_x - kFocal) * other.ty).maxCoeff(), 1e-6);
}

TEST(NominalSurface, RaysAreThoseOfTheScalarTemplates) {
  const Mirror mirror = mirror_with(kAll, -0.4);
  for (const PupilSample& pupil : pupils())
    for (const double slope : {0.0, 1e-5}) {
      const SurfaceField field = rough_field(pupil.size(), slope);
      const RayBundle rays = slope > 0 ? trace(mirror, pupil, field) : trace_nominal(mirror, pupil, 2);
      for (Eigen::Index i = 0; i < pupil.size(); ++i) {
        SurfacePoint<double> s = base_surface(mirror, pupil.x[i], pupil.y[i]);
        s.height += field.height[i];
        s.slope_x += field.slope_x[i];
        s.slope_y += field.slope_y[i];
        const Ray<double> ray = reflect(kFocal, pupil.x[i], pupil.y[i], s);
        EXPECT_NEAR(rays.x[i], ray.x, 2e-15);
        EXPECT_NEAR(rays.ty[i], ray.ty, 2e-15);
      }
    }
}

// Landing and direction of each ray, differentiated by a step along the imaginary axis.
TEST(NominalSurface, AdjointIsThatOfTheTraceWithTheZernikes) {
  using Complex = std::complex<double>;
  constexpr double kStep = 1e-40;
  const Mirror mirror = mirror_with({{4, 2e-4}, {5, -1e-4}, {8, 3e-4}});  // large, so that their part shows
  const PupilSample pupil = pupils()[2];
  const SurfaceField field = rough_field(pupil.size(), 1e-3);
  RayGradient gradient;
  gradient.all_rays = true;
  const auto ones = std::vector<double>(std::size_t(pupil.size()), 1.0);
  gradient.d_x = ones;
  gradient.d_ty = ones;
  const SurfaceField found = trace_adjoint(mirror, pupil, field, gradient);
  for (Eigen::Index i = 0; i < pupil.size(); i += 11) {
    const auto derivative = [&](int component) {
      const SurfacePoint<double> base = base_surface(mirror, pupil.x[i], pupil.y[i]);
      SurfacePoint<Complex> s{base.height + field.height[i], base.slope_x + field.slope_x[i],
                              base.slope_y + field.slope_y[i]};
      (component == 0 ? s.height : component == 1 ? s.slope_x : s.slope_y) += Complex(0, kStep);
      const Ray<Complex> ray = reflect(kFocal, Complex(pupil.x[i]), Complex(pupil.y[i]), s);
      return (ray.x + ray.ty).imag() / kStep;
    };
    EXPECT_NEAR(found.height[i], derivative(0), 1e-13);
    EXPECT_NEAR(found.slope_x[i], derivative(1), 1e-12);
    EXPECT_NEAR(found.slope_y[i], derivative(2), 1e-12);
  }
}

// Central differences include the mirror's Zernikes. Z11 has a third derivative, so the difference has an
// error of step^2/6 times it, and `trace` gives the rays of that surface.
TEST(NominalSurface, CentralDifferencesSeeTheKnownZernikes) {
  constexpr double kHeight = 2e-6, kStep = 5e-3;
  const Mirror mirror = mirror_with({{11, kHeight}});
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = {{2, 0}};
  const PupilSample pupil = pupils()[0];
  const SurfaceField field =
      central_difference_field(mirror, pupil, terms, Eigen::VectorXd::Zero(1), kStep, 1);
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const double x = pupil.x[i], y = pupil.y[i];
    // Along x, z = sqrt(5) a (6 u^4 + ...) with u = x/R. The difference adds exactly step^2/6 z'''.
    const double third = std::sqrt(5.0) * kHeight * 144 * x / std::pow(kRadius, 4);
    EXPECT_NEAR(field.slope_x[i], kStep * kStep / 6 * third, 1e-12) << x << ' ' << y;
  }
}

TEST(NominalSurface, CharacterisationStandsOnTheMirrorWithItsZernikes) {
  constexpr double kDefocus = 3e-6, kTilt = 2e-6;
  const Mirror mirror = mirror_with({{4, kDefocus}, {2, kTilt}});
  const Aperture aperture = CircleAperture{2 * kRadius};
  const MirrorCharacterisation found = characterise(mirror, aperture, 36);
  EXPECT_NEAR(found.vertex.z(), -std::sqrt(3.0) * kDefocus, 1e-18);
  const double rim = kRadius * kRadius / (4 * kFocal) + std::sqrt(3.0) * kDefocus;
  EXPECT_NEAR(found.rim_sag_max - found.rim_sag_min, 2 * 2 * kTilt, 1e-12);
  EXPECT_NEAR(found.plane_point.z(), rim, 1e-12);
  EXPECT_NEAR(-found.plane_normal.x() / found.plane_normal.z(), 2 * kTilt / kRadius, 1e-12);
}

}  // namespace
}  // namespace aberfit
