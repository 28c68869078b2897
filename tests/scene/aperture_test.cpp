#include "aberfit/scene/aperture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"

using namespace aberfit;

namespace {

constexpr double kHalfTurn = std::numbers::pi;
using Vertices = std::vector<std::array<double, 2>>;

const Vertices kArrow{{0.3, 0.0}, {-0.1, 0.25}, {0.02, 0.0}, {-0.1, -0.25}};  // not convex
const Vertices kOffset{
    {0.9, 0.4}, {1.3, 0.5}, {1.2, 0.9}, {1.05, 0.6}, {0.85, 0.8}};  // the axis is outside; not convex
const Vertices kNearEdge{
    {-0.2, 1e-4}, {0.3, 1e-4}, {0.3, 0.2}, {-0.2, 0.2}};  // one edge passes close to the axis
const Vertices kThroughAxis{
    {0.0, 0.0}, {0.2, 0.0}, {0.2, 0.2}, {-0.2, 0.2}, {-0.2, 0.0}};  // a corner on the axis

Vertices reversed(Vertices v) { return {v.rbegin(), v.rend()}; }

Vertices regular(int sides, double radius, double turn) {
  Vertices v;
  for (int i = 0; i < sides; ++i) {
    const double angle = turn + 2 * std::numbers::pi * i / sides;
    v.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return v;
}

// Moments of rho^2 over a polygon by Green's theorem. Five Gauss points per edge are exact to degree 9.
double polygon_rho_power(const Vertices& v, int half_power) {
  static const double node[5] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                 0.9061798459386640};
  static const double weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                   0.4786286704993665, 0.2369268850561891};
  double moment = 0, area = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto &a = v[i], &b = v[(i + 1) % v.size()];
    const double c = a[0] * b[1] - a[1] * b[0];
    area += 0.5 * c;
    // The integrand has degree 2k: over the triangle from the origin it is 1/(2k+2) times its edge mean.
    for (int k = 0; k < 5; ++k) {
      const double t = 0.5 * (1 + node[k]);
      const double x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]);
      moment += 0.5 * weight[k] * c * std::pow(x * x + y * y, half_power) / (2 * half_power + 2);
    }
  }
  return moment / area;
}

double mean_rho_power(const Aperture& aperture, int n, int half_power) {
  double sum = 0;
  for (const RadialNode& node : radial_quadrature(aperture, n))
    sum += node.weight * std::pow(node.rho, 2 * half_power);
  return sum;
}

constexpr double kRounding = 1e-13;
// The header states an error of 1e-13 for 16 points in each piece; the largest error is below 5e-14.
constexpr double kSixteenPoints = 1e-12;

// Crossing vanes subtract nothing twice, and no vane extends beyond the axis.
TEST(Obstructed, AreaIsThatOfWhatIsLeft) {
  const std::vector<Vane> cross{
      {0.02, 0, 0}, {0.02, kHalfTurn / 2, 0}, {0.02, kHalfTurn, 0}, {0.02, -kHalfTurn / 2, 0}};
  // Square: two strips of 1 x 0.02 have a common square in the middle.
  const Aperture square = RectangleAperture{1, 1};
  EXPECT_NEAR(aperture_area(obstructed(square, cross)), 1 - 2 * 0.02 + 0.02 * 0.02, 1e-14);
  EXPECT_NEAR(aperture_area(obstructed(square, {cross[0]})), 1 - 0.5 * 0.02, 1e-14);
  EXPECT_NEAR(aperture_area(obstructed(square, {{0.02, 0, 0.3}})), 1 - 0.5 * 0.02, 1e-14);
  // Annulus: a strip up to the radius r has the area y sqrt(r^2 - y^2) + r^2 asin(y/r), y its half width.
  const auto strip = [](double r) { return 0.01 * std::sqrt(r * r - 1e-4) + r * r * std::asin(0.01 / r); };
  const Aperture ring = AnnulusAperture{1, 0.3};
  EXPECT_NEAR(aperture_area(obstructed(ring, cross)) / (aperture_area(ring) - 4 * (strip(0.5) - strip(0.15))),
              1, 5e-6);
}

TEST(Obstructed, HoldsWhatNoVaneCovers) {
  const std::vector<Vane> vanes{{0.02, 0.4, 0}, {0.05, 2.0, 0.1}, {0.03, 2.0, 0}};
  const Aperture ring = AnnulusAperture{1, 0.3}, left = obstructed(ring, vanes);
  const RandomStream random(3, "obstructed");
  int held = 0;
  double weight = 0, second = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const auto [u, v] = random.uniform_pair(k);
    const double x = u - 0.5, y = v - 0.5;
    bool clear = aperture_contains(ring, x, y, 0);
    for (const Vane& vane : vanes) {
      const double along = x * std::cos(vane.angle) + y * std::sin(vane.angle),
                   left_of = y * std::cos(vane.angle) - x * std::sin(vane.angle);
      if (along > 0 && std::abs(left_of - vane.offset) < 0.5 * vane.width) clear = false;
    }
    EXPECT_EQ(aperture_contains(left, x, y, 0), clear) << x << ' ' << y;
    if (!clear) continue;
    ++held;
    second += x * x + y * y;
  }
  EXPECT_NEAR(held / 20000.0 / aperture_area(left), 1, 0.02);
  double of_nodes = 0;
  for (const RadialNode& node : radial_quadrature(left, 16))
    weight += node.weight, of_nodes += node.weight * node.rho * node.rho;
  EXPECT_NEAR(weight, 1, 1e-5);
  EXPECT_NEAR(of_nodes / (second / held), 1, 0.01);
}

// 3 n (n + 1) separate hexagons of area sqrt(3)/2 w^2; the farthest corner is in line with the axis.
TEST(HexagonalSegments, LieInRings) {
  for (const int rings : {1, 2, 3})
    for (const double angle : {0.0, 0.3}) {
      const SegmentedAperture segments = hexagonal_segments(rings, 1.3, 0.01, false, angle);
      const double count = 3.0 * rings * (rings + 1);
      EXPECT_EQ(double(segments.outlines.size()), count);
      EXPECT_NEAR(aperture_area(segments), count * 0.5 * std::sqrt(3.0) * 1.3 * 1.3, 1e-12);
      EXPECT_FALSE(aperture_contains(segments, 0, 0, 0));
      // Centres of neighbours along a side are one pitch apart; the gap between them is not clear.
      const double side = angle + kHalfTurn / 6;
      EXPECT_TRUE(aperture_contains(segments, 1.31 * std::cos(side), 1.31 * std::sin(side), 0.649));
      EXPECT_FALSE(aperture_contains(segments, 1.31 * std::cos(side), 1.31 * std::sin(side), 0.651));
    }
  EXPECT_EQ(hexagonal_segments(2, 1, 0, true, 0).outlines.size(), 19u);
  EXPECT_NEAR(aperture_radius(hexagonal_segments(1, 1, 0, true, 0)), std::sqrt(7.0 / 3), 1e-12);
}

// A grey edge is located to a fraction of a pixel, a hole remains a hole, and a grey interior is refused.
TEST(MaskOutlines, AreThoseOfTheShapeThatThePixelsShow) {
  const Eigen::Index side = 200;
  const double pitch = 0.01;
  const Aperture ring = AnnulusAperture{1.7, 0.6};
  Eigen::ArrayXXd share(side, side);
  constexpr int kFine = 8;
  for (Eigen::Index row = 0; row < side; ++row)
    for (Eigen::Index column = 0; column < side; ++column) {
      int inside = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const double x = pitch * (double(column) - 0.5 * side + (k % kFine + 0.5) / kFine),
                     y = pitch * (double(row) - 0.5 * side + (k / kFine + 0.5) / kFine);
        inside += aperture_contains(ring, x - 0.02, y, 0);
      }
      share(row, column) = inside / double(kFine * kFine);
    }
  const SegmentedAperture outlines = mask_outlines(share, pitch);
  EXPECT_EQ(outlines.outlines.size(), 2u);
  EXPECT_NEAR(aperture_area(outlines) / aperture_area(ring), 1, 1e-3);
  const ApertureBox box = bounding_box(outlines);
  EXPECT_NEAR(box.x0, 0.02 - 0.85, 0.1 * pitch);
  EXPECT_NEAR(box.x1, 0.02 + 0.85, 0.1 * pitch);
  EXPECT_NEAR(box.y1, 0.85, 0.1 * pitch);
  EXPECT_FALSE(aperture_contains(outlines, 0.02, 0, 0));
  EXPECT_TRUE(aperture_contains(outlines, 0.02, 0.5, 0.1));
  EXPECT_THROW(mask_outlines(0.6 * share, pitch), ComputationError);
  EXPECT_THROW(mask_outlines(0.3 * share, pitch), ComputationError);
  // For pixels of 0 or 1 the edge follows the pixels; each corner loses an eighth of a pixel.
  Eigen::ArrayXXd block = Eigen::ArrayXXd::Zero(64, 64);
  block.block(10, 12, 40, 30) = 1;
  const SegmentedAperture edges = mask_outlines(block, 1);
  EXPECT_NEAR(bounding_box(edges).x0, -20, 1e-12);
  EXPECT_NEAR(bounding_box(edges).x1, 10, 1e-12);
  EXPECT_NEAR(aperture_area(edges), 40 * 30 - 0.5, 1e-9);
}

}  // namespace

TEST(Aperture, RadiusAndAreaMatchClosedForms) {
  EXPECT_DOUBLE_EQ(aperture_radius(CircleAperture{0.4}), 0.2);
  EXPECT_DOUBLE_EQ(aperture_area(CircleAperture{0.4}), std::numbers::pi * 0.04);
  EXPECT_DOUBLE_EQ(aperture_radius(AnnulusAperture{0.4, 0.1}), 0.2);
  EXPECT_NEAR(aperture_area(AnnulusAperture{0.4, 0.1}), std::numbers::pi * (0.04 - 0.0025), 1e-16);
  EXPECT_DOUBLE_EQ(aperture_radius(RectangleAperture{0.6, 0.8}), 0.5);
  EXPECT_DOUBLE_EQ(aperture_area(RectangleAperture{0.6, 0.8}), 0.48);
  EXPECT_DOUBLE_EQ(aperture_radius(PolygonAperture{kOffset}), std::hypot(1.2, 0.9));
  EXPECT_NEAR(aperture_area(PolygonAperture{kArrow}), 0.5 * 0.5 * (0.4 - 0.12), 1e-16);
  EXPECT_NEAR(aperture_area(PolygonAperture{reversed(kArrow)}), 0.5 * 0.5 * (0.4 - 0.12), 1e-16);
}

TEST(RadialQuadrature, CircleAndAnnulusAreExactForPolynomialsInRhoSquared) {
  const double outer = 0.2, inner = 0.07;
  for (int k = 0; k < 16; ++k) {
    const double circle = std::pow(outer, 2 * k) / (k + 1);
    EXPECT_NEAR(mean_rho_power(CircleAperture{2 * outer}, 8, k) / circle, 1.0, kRounding);
    const double ring =
        (std::pow(outer, 2 * k + 2) - std::pow(inner, 2 * k + 2)) / (k + 1) / (outer * outer - inner * inner);
    EXPECT_NEAR(mean_rho_power(AnnulusAperture{2 * outer, 2 * inner}, 8, k) / ring, 1.0, kRounding);
  }
}

TEST(RadialQuadrature, RectangleMomentsMatchClosedForms) {
  const double a = 0.2, b = 0.05;  // half the sides
  const double rho2 = (a * a + b * b) / 3;
  const double rho4 = (a * a * a * a + b * b * b * b) / 5 + 2 * a * a * b * b / 9;
  for (const Aperture& aperture :
       {Aperture{RectangleAperture{2 * a, 2 * b}}, Aperture{RectangleAperture{2 * b, 2 * a}},
        Aperture{PolygonAperture{{{a, b}, {-a, b}, {-a, -b}, {a, -b}}}}}) {
    EXPECT_NEAR(mean_rho_power(aperture, 16, 0), 1.0, kSixteenPoints);
    EXPECT_NEAR(mean_rho_power(aperture, 16, 1) / rho2, 1.0, kSixteenPoints);
    EXPECT_NEAR(mean_rho_power(aperture, 16, 2) / rho4, 1.0, kSixteenPoints);
  }
}

TEST(RadialQuadrature, PolygonMomentsMatchGreensTheorem) {
  Vertices shifted = regular(6, 0.2, 0.3);
  for (auto& p : shifted) p = {p[0] + 0.5, p[1] - 0.1};
  for (const Vertices& v :
       {kArrow, kOffset, kNearEdge, kThroughAxis, regular(6, 0.2, 0.1), regular(3, 0.2, 0.0), shifted})
    for (const Vertices& sense : {v, reversed(v)})
      for (int k = 0; k <= 4; ++k)
        EXPECT_NEAR(mean_rho_power(PolygonAperture{sense}, 16, k) / polygon_rho_power(sense, k), 1.0,
                    kSixteenPoints)
            << v.size() << " corners, power " << 2 * k;
}

TEST(RadialQuadrature, WeightsAreSharesOfTheAreaAndStayInsideTheAperture) {
  for (const RadialNode& node : radial_quadrature(PolygonAperture{kOffset}, 12)) {
    EXPECT_GT(node.weight, 0.0);
    EXPECT_GE(node.rho, 0.98);  // distance of the nearest corner (0.9, 0.4)
    EXPECT_LE(node.rho, 1.5);   // distance of the farthest corner (1.2, 0.9)
  }
}

TEST(RadialQuadrature, ResolvesASmoothStepInRho) {
  // A Gaussian profile in rho^2 over a square is a product of two error functions.
  const double a = 0.2, width = 0.02;
  double mean = 0;
  for (const RadialNode& node : radial_quadrature(RectangleAperture{2 * a, 2 * a}, 64))
    mean += node.weight * std::exp(-node.rho * node.rho / (width * width));
  const double side = 0.5 * std::sqrt(std::numbers::pi) * width * std::erf(a / width) / a;
  EXPECT_NEAR(mean / (side * side), 1.0, 1e-11);
}

TEST(ApertureContains, LeavesOutTheHoleOfAnAnnulus) {
  const Aperture annulus = AnnulusAperture{0.4, 0.1};
  for (const double rho : {0.0, 0.02, 0.0499}) {
    EXPECT_FALSE(aperture_contains(annulus, rho, 0, 0)) << rho;
    EXPECT_FALSE(aperture_holds(annulus, -0.6 * rho, 0.8 * rho)) << rho;
  }
  for (const double rho : {0.0501, 0.1, 0.1999}) {
    EXPECT_TRUE(aperture_contains(annulus, rho, 0, 0)) << rho;
    EXPECT_TRUE(aperture_holds(annulus, -0.6 * rho, 0.8 * rho)) << rho;
  }
  EXPECT_FALSE(aperture_contains(annulus, 0.0501, 0, 0.001));  // closer to the hole than the margin
  EXPECT_TRUE(aperture_contains(annulus, 0.0511, 0, 0.001));
}

TEST(ApertureContains, AgreesWithBruteForceForEveryShape) {
  // Brute force: a point and 720 points on the circle of radius m about it must be inside.
  const RandomStream stream(7, "ApertureContains");
  const double margin = 0.01;
  const std::vector<Aperture> shapes{CircleAperture{0.4}, AnnulusAperture{0.4, 0.1},
                                     RectangleAperture{0.3, 0.2}, PolygonAperture{kArrow},
                                     PolygonAperture{reversed(kOffset)}};
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const double reach = aperture_radius(shapes[s]) * 1.1;
    int inside = 0, border = 0;
    for (int i = 0; i < 4000; ++i) {
      const auto u = stream.uniform_pair(std::uint64_t(i) + 10000 * s);
      const double x = reach * (2 * u[0] - 1), y = reach * (2 * u[1] - 1);
      const auto clear = [&](double radius) {
        for (int k = 0; k < 720; ++k) {
          const double angle = 2 * std::numbers::pi * k / 720;
          if (!aperture_contains(shapes[s], x + radius * std::cos(angle), y + radius * std::sin(angle), 0.0))
            return false;
        }
        return true;
      };
      const bool point = aperture_contains(shapes[s], x, y, 0.0);
      const bool with_margin = aperture_contains(shapes[s], x, y, margin);
      EXPECT_TRUE(point || !with_margin);
      // At straight edges the polygon of 720 sides is smaller by 1e-5 of the margin, at corners by more.
      if (with_margin) {
        EXPECT_TRUE(clear(margin * (1 - 1e-9))) << "shape " << s << " at " << x << ", " << y;
      } else if (point && clear(margin * 1.002)) {
        ++border;
      }
      inside += with_margin;
    }
    EXPECT_EQ(border, 0) << "shape " << s;
    EXPECT_GT(inside, 20) << "shape " << s;
  }
}

TEST(ApertureContains, FrequencyOfInsidePointsMatchesTheArea) {
  const RandomStream stream(8, "ApertureContains");
  const int n = 200000;
  for (const Aperture& shape : {Aperture{CircleAperture{0.4}}, Aperture{AnnulusAperture{0.4, 0.1}},
                                Aperture{RectangleAperture{0.3, 0.2}}, Aperture{PolygonAperture{kArrow}}}) {
    const double reach = aperture_radius(shape);
    int hits = 0;
    for (int i = 0; i < n; ++i) {
      const auto u = stream.uniform_pair(std::uint64_t(i));
      hits += aperture_contains(shape, reach * (2 * u[0] - 1), reach * (2 * u[1] - 1), 0.0);
    }
    const double share = aperture_area(shape) / (4 * reach * reach);
    EXPECT_NEAR(hits / double(n), share, 4 * std::sqrt(share * (1 - share) / n));  // four standard errors
  }
}

TEST(ApertureMargin, IsThatOfTheShape) {
  EXPECT_EQ(aperture_margin(CircleAperture{0.4, 1e-3}), 1e-3);
  EXPECT_EQ(aperture_margin(PolygonAperture{kArrow, 2e-3}), 2e-3);
}
