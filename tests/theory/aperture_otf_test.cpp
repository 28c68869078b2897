#include "aberfit/theory/aperture_otf.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/errors.h"
#include "regular_polygon.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

using Point = std::array<double, 2>;

PolygonAperture regular(int corners, double radius) { return test::regular_polygon(corners, radius, 0.1); }

// Common area of two convex polygons, corners counter-clockwise (Sutherland and Hodgman 1974).
double common_area(std::vector<Point> one, const std::vector<Point>& two) {
  for (std::size_t i = 0; i < two.size(); ++i) {
    const Point &a = two[i], &b = two[(i + 1) % two.size()];
    const auto side = [&](const Point& p) {
      return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    };
    std::vector<Point> kept;
    for (std::size_t k = 0; k < one.size(); ++k) {
      const Point &p = one[k], &q = one[(k + 1) % one.size()];
      const double at_p = side(p), at_q = side(q);
      if (at_p >= 0) kept.push_back(p);
      if ((at_p < 0) != (at_q < 0)) {
        const double t = at_p / (at_p - at_q);
        kept.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
      }
    }
    one = kept;
  }
  double twice = 0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    const Point &p = one[k], &q = one[(k + 1) % one.size()];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return 0.5 * twice;
}

// Error of polygons from their focal irradiance, as the header promises.
double allowed(double x, double diameter) { return x < 10 * diameter / 256 ? 1e-4 : 1e-5; }

}  // namespace

TEST(ApertureOtf, OfASquareDrawnAsAPolygonIsThatOfTheSquare) {
  const ApertureOtf polygon(PolygonAperture{{{-0.15, -0.1}, {0.15, -0.1}, {0.15, 0.1}, {-0.15, 0.1}}});
  const ApertureOtf rectangle(RectangleAperture{0.3, 0.2});
  EXPECT_NEAR(polygon.cutoff(), rectangle.cutoff(), 1e-15);
  for (const double x : {0.0, 0.01, 0.1, 0.19, 0.21, 0.29, 0.31, 0.36, 0.4}) {
    EXPECT_NEAR(polygon(x), rectangle(x), allowed(x, std::hypot(0.3, 0.2))) << x;
  }
}

TEST(ApertureOtf, OfConvexPolygonsIsTheMeanOfTheirIntersections) {
  for (const int corners : {3, 5, 6, 8}) {
    const PolygonAperture polygon = regular(corners, 0.2);
    const ApertureOtf otf(polygon);
    for (const double x : {0.003, 0.05, 0.12, 0.2, 0.27, 0.33}) {
      constexpr int kDirections = 2000;
      double sum = 0;
      for (int k = 0; k < kDirections; ++k) {
        std::vector<Point> moved = polygon.vertices;
        for (Point& p : moved) {
          p[0] += x * std::cos(2 * pi * (k + 0.5) / kDirections);
          p[1] += x * std::sin(2 * pi * (k + 0.5) / kDirections);
        }
        sum += common_area(moved, polygon.vertices);
      }
      EXPECT_NEAR(otf(x), sum / kDirections / aperture_area(polygon), allowed(x, 0.4)) << corners << " " << x;
    }
  }
}

TEST(ApertureOtf, OfAPolygonWithADentCountsWhatLies_InBothCopies) {
  // A letter L: three squares of side a. At the shear (x, y) >= 0 its overlap is a sum of rectangles.
  const double a = 0.1;
  const ApertureOtf otf(PolygonAperture{{{0, 0}, {2 * a, 0}, {2 * a, a}, {a, a}, {a, 2 * a}, {0, 2 * a}}});
  const auto overlap = [a](double dx, double dy) {  // on a grid of 300 by 300
    constexpr int kSide = 300;
    const auto inside = [a](double x, double y) {
      return x > 0 && y > 0 && ((x < 2 * a && y < a) || (x < a && y < 2 * a));
    };
    int count = 0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const double x = 2 * a * (i + 0.5) / kSide, y = 2 * a * (j + 0.5) / kSide;
        count += inside(x, y) && inside(x + dx, y + dy);
      }
    return 4.0 / 3 * count / (kSide * kSide);
  };
  for (const double x : {0.02, 0.08, 0.13}) {
    constexpr int kDirections = 120;
    double sum = 0;
    for (int k = 0; k < kDirections; ++k)
      sum += overlap(x * std::cos(2 * pi * (k + 0.5) / kDirections),
                     x * std::sin(2 * pi * (k + 0.5) / kDirections));
    EXPECT_NEAR(otf(x), sum / kDirections, 2e-3) << x;  // grid cells at the edges
  }
}

TEST(ApertureOtf, OfManyCornersIsThatOfTheCircle) {
  const ApertureOtf polygon(regular(90, 0.2)), circle(CircleAperture{0.4});
  for (const double x : {0.01, 0.1, 0.2, 0.35})
    EXPECT_NEAR(polygon(x), circle(x), 1e-3) << x;  // area: (2 pi/90)^2/6
}

TEST(ApertureOtf, RefusesWhatLetsNoLightThrough) {
  EXPECT_THROW(ApertureOtf(PolygonAperture{{{0, 0}, {1, 0}, {2, 0}}}), ComputationError);
  EXPECT_THROW(ApertureOtf(CircleAperture{0}), ComputationError);
}
