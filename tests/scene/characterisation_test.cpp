#include "aberfit/scene/characterisation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

using namespace aberfit;

namespace {

constexpr double kRounding = 4e-16;  // for lengths up to 1 m; largest error 2e-16
const Mirror kParabola{2.8, -1, {}};

double sag(double x, double y) { return (x * x + y * y) / (4 * 2.8); }

}  // namespace

TEST(Characterisation, RimOfACircleOnAParabolaIsPlanar) {
  const double radius = 0.2;
  const MirrorCharacterisation c = characterise(kParabola, CircleAperture{2 * radius, 0.01}, 360);
  ASSERT_EQ(c.rim.cols(), 360);
  for (Eigen::Index i = 0; i < 360; ++i) EXPECT_NEAR(c.rim.col(i).head<2>().norm(), radius, kRounding);
  EXPECT_EQ(c.vertex.norm(), 0.0);
  EXPECT_EQ(c.centroid.norm(), 0.0);
  EXPECT_NEAR(c.plane_point.z(), radius * radius / (4 * 2.8), kRounding);
  EXPECT_LT(c.plane_point.head<2>().norm(), kRounding);
  EXPECT_LT((c.plane_normal - Eigen::Vector3d::UnitZ()).norm(), 10 * kRounding);
  EXPECT_LT(c.plane_residual, kRounding);
  EXPECT_NEAR(c.rim_sag_min, radius * radius / (4 * 2.8), kRounding);
  EXPECT_NEAR(c.rim_sag_max, radius * radius / (4 * 2.8), kRounding);
  EXPECT_DOUBLE_EQ(c.f_number, 7.0);
}

TEST(Characterisation, HoleOfAnAnnulusDoesNotCountAsRim) {
  const MirrorCharacterisation c = characterise(kParabola, AnnulusAperture{0.4, 0.1}, 16);
  ASSERT_EQ(c.rim.cols(), 16);
  for (Eigen::Index i = 0; i < 16; ++i) EXPECT_NEAR(c.rim.col(i).head<2>().norm(), 0.2, kRounding);
}

TEST(Characterisation, RimOfAnAnnulusHoweverSlenderIsItsOuterCircle) {
  const MirrorCharacterisation slender =
      characterise(Mirror{.focal_length = 1.4}, AnnulusAperture{0.2, 0.2 * (1 - 1e-6)});
  ASSERT_EQ(slender.rim.cols(), 360);
  EXPECT_NEAR(slender.rim_sag_max, 0.1 * 0.1 / (4 * 1.4), 1e-15);  // rho^2/(4 f)
  EXPECT_LT(slender.plane_residual, 1e-15);
}

TEST(Characterisation, SquareHasTheSagsOfItsCornersAndSideCentres) {
  const double a = 0.15;  // half the side; eight directions meet four corners and four side centres
  const MirrorCharacterisation c = characterise(kParabola, RectangleAperture{2 * a, 2 * a}, 8);
  ASSERT_EQ(c.rim.cols(), 8);
  EXPECT_NEAR(c.rim_sag_max, sag(a, a), 4 * kRounding);
  EXPECT_NEAR(c.rim_sag_min, sag(a, 0), kRounding);
  EXPECT_NEAR(c.plane_point.z(), 0.5 * (sag(a, a) + sag(a, 0)), kRounding);
  EXPECT_NEAR(c.plane_residual, 0.5 * (sag(a, a) - sag(a, 0)), kRounding);
  EXPECT_LT((c.plane_normal - Eigen::Vector3d::UnitZ()).norm(), 100 * kRounding);
}

TEST(Characterisation, RectangleRimLiesOnItsSides) {
  const double a = 0.2, b = 0.1;
  const MirrorCharacterisation c = characterise(kParabola, RectangleAperture{2 * a, 2 * b}, 90);
  for (Eigen::Index i = 0; i < 90; ++i) {
    const Eigen::Vector3d p = c.rim.col(i);
    EXPECT_NEAR(std::max(std::abs(p.x()) / a, std::abs(p.y()) / b), 1.0, 4e-15);
    EXPECT_NEAR(p.z(), sag(p.x(), p.y()), kRounding);
  }
  EXPECT_LE(c.rim_sag_max, sag(a, b) * (1 + kRounding));
  EXPECT_NEAR(c.rim_sag_min, sag(0, b), sag(0, b) * 4e-3);  // the nearest direction is within 2 degrees of y
}

TEST(Characterisation, OffAxisCircleOnAParabolaHasATiltedPlanarRim) {
  // The intersection of a paraboloid with a vertical circular cylinder is planar: z = (2 x x0 - x0^2 +
  // a^2)/(4 f). So the plane has slope x0/(2 f). A polygon of 720 sides agrees with its circle to
  // (pi/720)^2/2 = 1e-5.
  const double x0 = 0.5, a = 0.1;
  PolygonAperture segment;
  for (int i = 0; i < 720; ++i)
    segment.vertices.push_back(
        {x0 + a * std::cos(2 * std::numbers::pi * i / 720), a * std::sin(2 * std::numbers::pi * i / 720)});
  const MirrorCharacterisation c = characterise(kParabola, segment, 180);  // the rim has every fourth corner
  ASSERT_EQ(c.rim.cols(), 180);
  EXPECT_NEAR(c.centroid.x(), x0, 4e-15);
  EXPECT_NEAR(c.centroid.z(), x0 * x0 / 11.2, 4e-15);
  const double slope = x0 / (2 * 2.8);
  const Eigen::Vector3d normal = Eigen::Vector3d(-slope, 0, 1).normalized();
  EXPECT_LT((c.plane_normal - normal).norm(), 1e-12);
  EXPECT_LT(c.plane_residual, 1e-14);
}

TEST(Characterisation, BentPolygonGivesItsOutermostEdgeAndSkipsEmptyDirections) {
  // The centroid of this thin L lies outside it. There is no edge towards the open side.
  const PolygonAperture bent{{{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.1}, {0.1, 0.1}, {0.1, 1.0}, {0.0, 1.0}}};
  const double area = 0.1 + 0.09, centre = (0.1 * 0.5 + 0.09 * 0.05) / area;
  const MirrorCharacterisation c = characterise(kParabola, bent, 8);
  EXPECT_NEAR(c.centroid.x(), centre, 1e-15);
  EXPECT_NEAR(c.centroid.y(), centre, 1e-15);
  // Directions 0, 45 and 90 degrees miss the L. Five directions meet it: 135, 180, 225, 270 and 315 degrees.
  ASSERT_EQ(c.rim.cols(), 5);
  EXPECT_NEAR(c.rim(0, 1), 0.0, 4e-16);  // 180 degrees: outer side x = 0, not inner side x = 0.1
  EXPECT_NEAR(c.rim(1, 3), 0.0, 4e-16);
}

TEST(Characterisation, SphereHasItsOwnSag) {
  const Mirror sphere{0.5, 0, {}};  // radius of curvature 1 m
  const MirrorCharacterisation c = characterise(sphere, CircleAperture{0.8}, 12);
  EXPECT_NEAR(c.rim_sag_max, 1 - std::sqrt(1 - 0.16), kRounding);
  EXPECT_NEAR(c.plane_residual, 0.0, kRounding);
}
