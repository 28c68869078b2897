// The pupil's overlap far out of focus against its integral: encircled energies that both give with Gaussian
// roughness, and where each is taken.
#include "../../src/theory/far_overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../../src/theory/exact_transfer.h"
#include "../../src/theory/pupil_overlap.h"
#include "aberfit/core/errors.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "regular_polygon.h"
#include "short_form.h"

namespace aberfit {
namespace {

using internal::FarOverlap;
using internal::PupilField;
using internal::PupilOverlap;

constexpr double kLambda = 633e-9, kDiameter = 0.4, pi = std::numbers::pi;

const Aperture kRectangle = RectangleAperture{0.32, 0.24};
const Aperture kHexagon =
    PolygonAperture{{{0.2, 0}, {0.1, 0.173}, {-0.1, 0.17}, {-0.19, 0.02}, {-0.1, -0.17}, {0.1, -0.16}}};
const Aperture kQuarter = PolygonAperture{{{0, 0}, {0.141, 0}, {0.141, 0.141}, {0, 0.141}}};

struct Plane {
  PupilField field;
  double dz = 0, scale = 0;  // of the roughness's transfer exp(-(x/scale)^2/2) [m]
};

// `phase` [rad] from axis to rim; the roughness spreads light over `spread` of the cone of rays, RMS.
Plane plane(const Aperture& aperture, double f_number, double phase, double spread) {
  const double f = f_number * kDiameter;
  const double dz = phase * kLambda * 8 * f_number * f_number / (2 * pi), cone = dz / (2 * f_number);
  return {PupilField(Mirror{f, -1, {}}, aperture, kLambda, {}), dz, kLambda * f / (2 * pi * spread * cone)};
}

// E at twenty radii up to the cone's rim and beyond, of a transfer given as sum of moments.
template <class Moments>
Eigen::ArrayXd encircled(const Plane& at, const Moments& moments) {
  const double f = at.field.focal_length(), end = std::min(2 * at.field.outer(), 6 * at.scale);
  constexpr int kShears = 2001;
  const double step = end / (kShears - 1), cone = at.dz * 0.5 * kDiameter / f;
  Eigen::ArrayXd transfer(kShears);
  for (int k = 0; k < kShears; ++k)
    transfer[k] = moments(k * step).sum() * std::exp(-0.5 * std::pow(k * step / at.scale, 2));
  Eigen::ArrayXd result(20);
  for (int r = 0; r < 20; ++r) {
    const double u = 2 * pi / (kLambda * (f + at.dz)) * 0.06 * (r + 1) * cone;
    double sum = 0;
    for (int k = 0; k < kShears; ++k) {  // Simpson
      const double weight = k == 0 || k + 1 == kShears ? 1 : k % 2 == 1 ? 4 : 2, z = u * k * step;
      double j0 = 0, j1 = 0;
      bessel_j0_j1(&z, 1, &j0, &j1);
      sum += weight * transfer[k] * j1;
    }
    result[r] = u * sum * step / 3;
  }
  return result;
}

struct Compared {
  double off = 0, said = 0;
};
Compared compared(const Aperture& aperture, double f_number, double phase, double spread, int order) {
  const Plane at = plane(aperture, f_number, phase, spread);
  PupilOverlap near(at.field, at.dz, order);
  near.set_correction();
  const FarOverlap far(at.field, at.dz, near.nodes(), PupilOverlap(at.field, 0, order)(0));
  const Eigen::ArrayXd difference = encircled(at, far) - encircled(at, [&](double x) { return near(x); });
  // exp(-3.03^2/2) = kBlurred
  return {difference.abs().maxCoeff(), FarOverlap::error(at.field, at.dz, 3.03 * at.scale)};
}

TEST_WITH_SHORT_FORM(FarOverlap, ErrsByWhatItSaysForEveryShapeAndSpeed) {
  const Aperture circle = CircleAperture{kDiameter}, annulus = AnnulusAperture{kDiameter, 0.15};
  const std::vector<std::tuple<Aperture, double, double, double, int>> cases{
      {circle, 8, 150, 0.3, 1},        {circle, 2.5, 150, 0.3, 2},     {circle, 2.5, 400, 0.3, 2},
      {circle, 1.3, 150, 1, 4},        {circle, 2.5, 400, 0.01, 2},    {circle, 8, 500, 0.01, 1},
      {kRectangle, 2.5, 150, 0.01, 1}, {kHexagon, 1.3, 60, 0.01, 2},   {annulus, 2.5, 150, 0.3, 2},
      {annulus, 1.3, 150, 0.3, 6},     {kRectangle, 2.5, 150, 0.3, 2}, {kRectangle, 1.3, 150, 1, 3},
      {kHexagon, 2.5, 150, 0.3, 2},    {kQuarter, 2.5, 300, 0.3, 2}};
  for (const auto& [aperture, f_number, phase, spread, order] : test::all_or_few(whole, cases, {0, 8, 10})) {
    const Compared found = compared(aperture, f_number, phase, spread, order);
    EXPECT_LT(found.off, found.said) << f_number << ' ' << phase << ' ' << spread;
    EXPECT_GT(found.off, 0.1 * found.said) << f_number << ' ' << phase << ' ' << spread;
  }
}

// Its moments are those of the integral one by one, which roughness that differs over the aperture takes
// apart: of azimuths along and across the shear, of rim and middle.
TEST(FarOverlap, HasEveryMomentOfTheIntegral) {
  const Plane at = plane(CircleAperture{kDiameter}, 2.5, 800, 1);
  for (const int order : {2, 5}) {
    const PupilOverlap near(at.field, at.dz, order);
    const FarOverlap far(at.field, at.dz, near.nodes(), PupilOverlap(at.field, 0, order)(0));
    for (const double x : {0.0, 1e-5, 3e-5, 1e-4, 2e-4, 4e-4})  // 3 rad for a ray from the rim
      EXPECT_LT((far(x) - near(x)).abs().maxCoeff(), 2 * x / kDiameter + 1e-6) << order << ' ' << x;
    EXPECT_GT((near(4e-4) - near(0)).abs().maxCoeff(), 0.1);
  }
}

TEST(FarOverlap, KnowsNothingNearTheFocus) {
  const Plane at = plane(CircleAperture{kDiameter}, 2.5, 30, 1);
  EXPECT_EQ(FarOverlap::error(at.field, at.dz, at.scale), HUGE_VAL);
  EXPECT_EQ(FarOverlap::error(at.field, 0, at.scale), HUGE_VAL);
}

// What the wave theory takes there, for Gaussian roughness of height sigma [m].
MeanSpot of_mirror(const Aperture& aperture, double f_number, double phase, double sigma) {
  const Plane at = plane(aperture, f_number, phase, 1);
  const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{sigma, 0.02}),
                                     Mirror{at.field.focal_length(), -1, {}}, aperture, kLambda);
  return light.at_plane(at.dz);
}

// Where fringes are sharp the integral is taken, 3e-4 better. A hexagon at f/1.3 is within its work, to 3e-5
// of ten times as much at 700 rad; an outline of forty edges is not, and has a value where roughness blurs
// the fringes, else none.
TEST_WITH_SHORT_FORM(FarOverlap, IsTakenWhereItIsGoodAndWhereTheIntegralIsTooLong) {
  const Plane sharp = plane(kRectangle, 5, 150, 1e-9);
  PupilOverlap integral(sharp.field, sharp.dz, 1);
  integral.set_correction();
  const Eigen::ArrayXd truth = encircled(sharp, [&](double x) { return integral(x); });
  const MeanSpot taken = of_mirror(kRectangle, 5, 150, 1e-13);
  double off = 0;
  for (int r = 0; r < 20; ++r)
    off = std::max(off, std::abs(taken.encircled_energy(0.06 * (r + 1) * sharp.dz / 10) - truth[r]));
  EXPECT_LT(off, 1e-4);

  EXPECT_NO_THROW(of_mirror(kHexagon, 1.3, 400, 3e-7));
  if (!whole) return;
  EXPECT_NO_THROW(of_mirror(kHexagon, 1.3, 700, 4e-7));
  EXPECT_NO_THROW(of_mirror(kHexagon, 1.3, 700, 2e-8));
  EXPECT_THROW(of_mirror(test::regular_polygon(40, 0.2, 0.1), 1.3, 700, 2e-8), ComputationError);
}

// Whether moments at one shear are the far overlap's, not the integral's.
bool is_far(const Plane& at, const internal::Fading& fading) {
  const internal::PupilMoments moments(at.field, 0);
  PupilOverlap near(at.field, at.dz, moments.order());
  near.set_correction();
  const FarOverlap far(at.field, at.dz, near.nodes(), moments.whole());
  const auto found = moments.panels(at.dz, 1, fading.from());
  const internal::MomentPanel& first = found->panels.front();
  const double s = 0.5 * (first.a + first.b), here = first.at(s, first.legendre()).sum();
  const double by_far = far(s * near.cutoff()).sum(), by_near = near(s * near.cutoff()).sum();
  EXPECT_GT(std::abs(by_far - by_near), 1e-6);
  return std::abs(here - by_far) < std::abs(here - by_near);
}

// Means over the azimuth take it wherever it errs by next to nothing, and by less than a thousandth of the
// light where the integral would be too long.
TEST_WITH_SHORT_FORM(FarOverlap, IsTakenForMeansByItsErrorAndTheirWork) {
  const internal::Fading blurs({0.01, 0.02, 1, 1, 1, 1, 1, 1}), none;
  EXPECT_FALSE(is_far(plane(kHexagon, 5, 100, 1), none));  // fringes
  EXPECT_TRUE(is_far(plane(kHexagon, 5, 100, 1), blurs));
  if (!whole) return;
  EXPECT_FALSE(is_far(plane(kHexagon, 1.3, 100, 1), blurs));
  const Aperture of_edges = test::regular_polygon(20, 0.2, 0.1);
  EXPECT_FALSE(is_far(plane(of_edges, 1.3, 60, 1), blurs));
  EXPECT_TRUE(is_far(plane(of_edges, 1.3, 700, 1), internal::Fading({0.005, 0.01, 1, 1, 1, 1, 1, 1})));
}

// All of the light of a smooth mirror, further out than any panel of the integral would go: E against the
// rays of the cone alone, from which fringes at the rim differ by less than they are wide.
TEST(FarOverlap, IsResolvedHoweverFarThePlane) {
  for (const Aperture& aperture : {kRectangle, kHexagon})
    for (const double phase : {800.0, 2000.0, 20000.0}) {
      const Plane at = plane(aperture, 8, phase, 1);
      const MeanSpot spot = of_mirror(aperture, 8, phase, 1e-13);
      const std::vector<RadialNode> rays = radial_quadrature(aperture, 4000);
      for (const double part : {0.2, 0.45, 0.7, 0.95}) {
        double inside = 0;
        for (const RadialNode& ray : rays) {
          const double t = ray.rho / (2 * at.field.focal_length());
          // tan of the ray's angle, times the distance from the focus.
          if (2 * t / (1 - t * t) * at.dz < part * at.dz / 16) inside += ray.weight;
        }
        EXPECT_NEAR(spot.encircled_energy(part * at.dz / 16), inside, 0.3 / std::sqrt(phase) * part)
            << phase << ' ' << part;
      }
    }
}

// A segment that the axis passes by: the phase turns little over it, whatever it is at its distance.
TEST(FarOverlap, GoesByTheSegmentNotByItsDistance) {
  const Aperture segment = PolygonAperture{{{0.15, -0.02}, {0.2, -0.02}, {0.2, 0.02}, {0.15, 0.02}}};
  const Plane at = plane(segment, 2.5, 400, 1);
  EXPECT_EQ(FarOverlap::error(at.field, at.dz, at.scale), HUGE_VAL);
  EXPECT_GT(PupilOverlap(at.field, at.dz, 1).turn(0.4), 10);
  EXPECT_GT(PupilOverlap(at.field, at.dz, 1).points(0.01), 100u);
}

// A mirror far from its parabola: with hundreds of waves its overlap is out of reach, but where the roughness
// leaves 2e-5 of the light its mean spot takes short shears alone. Against Simpson's rule over these.
TEST_WITH_SHORT_FORM(ExactTransfer, TakesShortShearsOfManyWaves) {
  constexpr double kHeight = 3.28, kLength = 2e-4, kFocalLength = 8;  // g; m
  const double sigma = kHeight * kLambda / (4 * pi);
  for (const Aperture& aperture : {Aperture(CircleAperture{kDiameter}), kHexagon})
    for (const double conic : {100.0, 2000.0}) {
      if (!whole && (conic > 1000) != (aperture.index() == 0)) continue;
      const Mirror mirror{kFocalLength, conic, {}};
      const PupilField field(mirror, aperture, kLambda, {});
      const double dz = 0.01;
      PupilOverlap overlap(field, dz, 1);
      overlap.set_correction();
      ASSERT_EQ(overlap.turn(kDiameter) > 1500, conic > 1000) << overlap.turn(kDiameter);
      const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{sigma, kLength}), mirror, aperture, kLambda);
      const MeanSpot spot = light.at_plane(dz);
      const auto transfer = [&](double x) {
        return std::exp(kHeight * kHeight *
                        std::expm1(-x * x / (kLength * kLength)));  // f/20: all heights count
      };
      constexpr int kShears = 401;
      const double end = 3.2 * kLength, step = end / (kShears - 1);
      Eigen::ArrayXd seen(kShears);
      for (int k = 0; k < kShears; ++k) seen[k] = overlap(k * step).sum() * transfer(k * step);
      for (const double fraction : {0.2, 0.5, 0.8, 0.95}) {
        const double radius = spot.encircled_energy_radius(fraction);
        const double u = 2 * pi * radius / (kLambda * (kFocalLength + dz));
        double sum = 0;
        for (int k = 0; k < kShears; ++k) {
          const double weight = k == 0 || k + 1 == kShears ? 1 : k % 2 == 1 ? 4 : 2, z = u * k * step;
          double j0 = 0, j1 = 0;
          bessel_j0_j1(&z, 1, &j0, &j1);
          sum += weight * seen[k] * j1;
        }
        EXPECT_NEAR(u * sum * step / 3, fraction, 2e-4) << conic << ' ' << fraction;
      }
    }
}

// A core of 1e-7 of the light is most of what there is on the axis of a rough mirror: out of focus and of a
// mirror with aberrations it is as it is in the focus of a perfect one.
TEST(ExactTransfer, KeepsAWeakCoreOfAnyMirror) {
  constexpr double kHeight = 4, kLength = 2e-5;
  const RadialPsd psd(GaussianPsd{kHeight * kLambda / (4 * pi), kLength});
  for (const Aperture& aperture : {Aperture(CircleAperture{0.1}), Aperture(RectangleAperture{0.08, 0.06})}) {
    const GeneralisedHarveyShack perfect(psd, Mirror{1, -1, {}}, aperture, kLambda),
        conic(psd, Mirror{1, -0.9999, {}}, aperture, kLambda);
    const double axis = perfect.at_plane(0).irradiance(0);
    EXPECT_NEAR(perfect.at_plane(1e-7).irradiance(0) / axis, 1, 1e-3);
    EXPECT_NEAR(conic.at_plane(0).irradiance(0) / axis, 1, 1e-3);
    // The core's own share of it is not small.
    const double core = std::exp(-kHeight * kHeight) * aperture_area(aperture) / std::pow(kLambda, 2);
    EXPECT_GT(core, 0.2 * axis);
  }
}

}  // namespace
}  // namespace aberfit
