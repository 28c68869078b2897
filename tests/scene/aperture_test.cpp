#include "aberfit/scene/aperture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/random.h"

using namespace aberfit;

namespace {

using Vertices = std::vector<std::array<double, 2>>;

const Vertices kArrow{{0.3, 0.0}, {-0.1, 0.25}, {0.02, 0.0}, {-0.1, -0.25}};  // not convex
const Vertices kOffset{
    {0.9, 0.4}, {1.3, 0.5}, {1.2, 0.9}, {1.05, 0.6}, {0.85, 0.8}};  // axis outside, not convex
const Vertices kNearEdge{
    {-0.2, 1e-4}, {0.3, 1e-4}, {0.3, 0.2}, {-0.2, 0.2}};  // an edge passes the axis closely
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

// Moments int x^a y^b over a polygon by Green's theorem with the binomial sums of a linear edge written out
// as a Gauss rule of five points: exact up to degree 9 along the edge.
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
    // Homogeneous integrand of degree 2k over the triangle from the origin: 1/(2k+2) times its mean over the
    // edge.
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
// What the header promises for 16 points a piece; largest seen below 5e-14.
constexpr double kSixteenPoints = 1e-12;

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
  const double a = 0.2, b = 0.05;  // half sides
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
    EXPECT_GE(node.rho, 0.98);  // nearest corner (0.9, 0.4)
    EXPECT_LE(node.rho, 1.5);   // farthest (1.2, 0.9)
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
  EXPECT_FALSE(aperture_contains(annulus, 0.0501, 0, 0.001));  // nearer to the hole than the margin
  EXPECT_TRUE(aperture_contains(annulus, 0.0511, 0, 0.001));
}

TEST(ApertureContains, AgreesWithBruteForceForEveryShape) {
  // Brute force: a point is in with margin m when the point and 720 points on the circle of radius m about it
  // are in.
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
      // The 720-gon is up to 1e-5 of the margin smaller than the circle at straight edges, more at corners.
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
