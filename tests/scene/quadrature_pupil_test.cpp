#include "aberfit/scene/quadrature_pupil.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/core/quadrature.h"

namespace aberfit {
namespace {

constexpr double kRounding = 2e-13;  // for monomials of largest value 1; largest error 4e-14

// Mean of x^a y^b over the unit disc: 0 unless both are even, else a! b!/(2^(a+b) (a/2)! (b/2)!
// ((a+b)/2+1)!).
double mean_over_disc(int a, int b) {
  if (a % 2 != 0 || b % 2 != 0) return 0;
  return std::exp(std::lgamma(a + 1.0) + std::lgamma(b + 1.0) - (a + b) * std::log(2.0) -
                  std::lgamma(a / 2 + 1.0) - std::lgamma(b / 2 + 1.0) - std::lgamma((a + b) / 2 + 2.0));
}

// Integral of x^a y^b over a polygon; the divergence theorem gives that of x^(a+1) y^b/(a+1) dy along edges.
double integral_over(const PolygonAperture& polygon, int a, int b) {
  const Quadrature rule = gauss_legendre((a + b) / 2 + 2, 0, 1);
  double sum = 0;
  for (std::size_t e = 0; e < polygon.vertices.size(); ++e) {
    const auto &p = polygon.vertices[e], &q = polygon.vertices[(e + 1) % polygon.vertices.size()];
    for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
      const double x = p[0] + rule.nodes[i] * (q[0] - p[0]), y = p[1] + rule.nodes[i] * (q[1] - p[1]);
      sum += rule.weights[i] * std::pow(x, a + 1) * std::pow(y, b) / (a + 1) * (q[1] - p[1]);
    }
  }
  return sum;
}

double mean_at(const PupilSample& pupil, int a, int b) {
  double sum = 0;
  for (Eigen::Index i = 0; i < pupil.size(); ++i)
    sum += pupil.weight[i] * std::pow(pupil.x[i], a) * std::pow(pupil.y[i], b);
  return sum;
}

// Compares all monomials up to the degree of the rule with `mean`. The next even monomial must fail, which
// shows that there are no unnecessary points.
template <typename Mean>
void expect_exact(const Aperture& aperture, const Mean& mean) {
  for (const int degree : {0, 1, 2, 7, 12, 41}) {
    const PupilSample pupil = quadrature_pupil(aperture, degree);
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        EXPECT_NEAR(mean_at(pupil, a, b), mean(a, b), kRounding) << degree << ' ' << a << ' ' << b;
  }
  const PupilSample few = quadrature_pupil(aperture, 12);
  EXPECT_GT(std::abs(mean_at(few, 16, 0) - mean(16, 0)), 1e-10);
}

TEST(QuadraturePupil, IsExactOnCircles) {
  expect_exact(CircleAperture{2, 0.1}, mean_over_disc);  // the margin is not subtracted
}

TEST(QuadraturePupil, IsExactOnAnnuli) {
  constexpr double kInner = 0.4;
  expect_exact(AnnulusAperture{2, 2 * kInner}, [](int a, int b) {
    return mean_over_disc(a, b) * (1 - std::pow(kInner, a + b + 2)) / (1 - kInner * kInner);
  });
}

TEST(QuadraturePupil, IsExactOnRectangles) {
  expect_exact(RectangleAperture{2, 1.2}, [](int a, int b) {
    return a % 2 != 0 || b % 2 != 0 ? 0.0 : std::pow(0.6, b) / ((a + 1.0) * (b + 1.0));
  });
}

TEST(QuadraturePupil, IsExactOnPolygonsOfAnyFormAndSense) {
  const PolygonAperture off_axis{{{0.1, 0.2}, {0.9, -0.1}, {0.7, 0.6}}};
  const PolygonAperture bent{{{-0.9, -0.2}, {0.0, 0.1}, {0.9, -0.2}, {0.0, 0.9}}};  // clockwise below
  const PolygonAperture hook{{{-1, -0.3}, {0, 0}, {-0.9, 0.3}, {0.5, 0.8}, {0.9, -0.4}, {0.6, 0.5}}};
  PolygonAperture reversed = bent;
  std::reverse(reversed.vertices.begin(), reversed.vertices.end());
  for (const PolygonAperture& polygon : {off_axis, bent, hook, reversed}) {
    const double area = integral_over(polygon, 0, 0);
    expect_exact(polygon, [&](int a, int b) { return integral_over(polygon, a, b) / area; });
  }
}

TEST(QuadraturePupil, MarginsComeOffWhereWhatIsLeftHasTheSameForm) {
  EXPECT_EQ(std::get<CircleAperture>(*without_margin(CircleAperture{2, 0.1})).diameter, 1.8);
  const auto annulus = std::get<AnnulusAperture>(*without_margin(AnnulusAperture{2, 0.5, 0.1}));
  EXPECT_EQ(annulus.diameter, 1.8);
  EXPECT_EQ(annulus.inner_diameter, 0.7);
  const auto rectangle = std::get<RectangleAperture>(*without_margin(RectangleAperture{2, 1, 0.25}));
  EXPECT_EQ(rectangle.width, 1.5);
  EXPECT_EQ(rectangle.height, 0.5);
  EXPECT_EQ(rectangle.margin, 0);
  const PolygonAperture triangle{{{0, 0}, {1, 0}, {0, 1}}};
  EXPECT_TRUE(without_margin(triangle).has_value());
  EXPECT_FALSE(without_margin(PolygonAperture{triangle.vertices, 0.01}).has_value());
}

}  // namespace
}  // namespace aberfit
