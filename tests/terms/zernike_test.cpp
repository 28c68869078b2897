#include "aberfit/scene/zernike.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include "aberfit/core/quadrature.h"
#include "aberfit/terms/surface_operator.h"
#include "zernike_exact.h"

using namespace aberfit;

namespace {

struct DiscPoints {
  Eigen::ArrayXd x, y;
  std::vector<zernike_exact::Point> exact;
};

/// Points at the vertex, near it, in mid-disc and densely at the rim, where unstable forms of R_n^m fail
/// first. Each radius has several angles that are no symmetry of a mode.
DiscPoints disc_points(const std::vector<double>& rhos, int angles, int m_max) {
  DiscPoints points{Eigen::ArrayXd(Eigen::Index(rhos.size()) * angles),
                    Eigen::ArrayXd(Eigen::Index(rhos.size()) * angles),
                    {}};
  for (std::size_t i = 0; i < rhos.size(); ++i)
    for (int j = 0; j < angles; ++j) {
      const Eigen::Index at = Eigen::Index(i) * angles + j;
      const double angle = 2 * std::numbers::pi * (j + 0.381966 * double(i)) / angles;
      points.x[at] = rhos[i] * std::cos(angle);
      points.y[at] = rhos[i] * std::sin(angle);
      points.exact.emplace_back(points.x[at], points.y[at], m_max);
    }
  return points;
}

/// Largest error of value and gradient, relative to the largest value and gradient over the disc.
struct Errors {
  double reference = 0, fused = 0;
  void grow(const Errors& other) {
    reference = std::max(reference, other.reference);
    fused = std::max(fused, other.fused);
  }
};

/// Lower bound of the largest gradient of an orthonormal mode over the disc, from its values at the rim.
/// There |grad|^2 is norm^2 times (R'(1) cos)^2 + (m sin)^2, with R'(1) = (n (n + 2) - m^2) / 2.
double largest_gradient(ZernikeMode mode) {
  return zernike_norm(mode) *
         std::max(0.5 * (mode.n * (mode.n + 2.0) - mode.m * mode.m), std::abs(mode.m) * 1.0);
}

Errors errors_of(ZernikeMode mode, const DiscPoints& points) {
  TermSet terms;
  terms.radius = 1.0;
  terms.zernike = {mode};
  const SurfaceOperator fused(terms, points.x, points.y);
  SurfaceField field;
  fused.apply(Eigen::VectorXd::Ones(1), &field);

  const double value_scale = zernike_norm(mode);  // |R_n^m| <= R_n^m(1) = 1
  const double gradient_scale = std::max(largest_gradient(mode), 1e-300);
  const zernike_exact::Radial radial = zernike_exact::radial(mode);
  Errors errors;
  for (Eigen::Index i = 0; i < points.x.size(); ++i) {
    const zernike_exact::Value exact = evaluate(radial, points.exact[std::size_t(i)]);
    const auto error = [&](double value, double dx, double dy) {
      const double of_value = std::abs(double(value - exact.value)) / value_scale;
      const double of_slope = std::hypot(double(dx - exact.dx), double(dy - exact.dy)) / gradient_scale;
      EXPECT_TRUE(std::isfinite(of_value + of_slope)) << mode.n << ", " << mode.m;
      return std::max(of_value, of_slope);
    };
    const ZernikeValue reference = zernike(mode, points.x[i], points.y[i]);
    errors.grow({error(reference.value, reference.dx, reference.dy),
                 error(field.height[i], field.slope_x[i], field.slope_y[i])});
  }
  return errors;
}

constexpr double kErrorTo100 = 1e-12, kErrorTo300 = 1e-11;  // from zernike.h

std::vector<double> radii() {
  std::vector<double> list = {0.0,  1e-9, 1e-3, 0.02, 0.07, 0.13, 0.2, 0.28, 0.35,
                              0.43, 0.5,  0.61, 0.7,  0.77, 0.83, 0.9, 0.94, 0.97};
  for (int i = 0; i <= 20; ++i) list.push_back(0.98 + 0.001 * i);
  for (const double from_rim : {3e-4, 1e-5, 1e-7, 1e-12}) list.push_back(1 - from_rim);
  return list;
}

}  // namespace

// Largest errors of the reference function: 5.3e-14 to n = 40, 3.2e-13 at n = 100, 2.8e-12 at n = 300. Those
// of the fused operator are slightly smaller.
TEST(Zernike, EveryModeTo40MatchesTheFactorialSumIn200Digits) {
  const DiscPoints points = disc_points(radii(), 7, 40);
  Errors worst;
  for (const ZernikeMode mode : zernike_modes(0, 40)) {
    const Errors errors = errors_of(mode, points);
    EXPECT_LE(errors.reference, kErrorTo100) << "n " << mode.n << " m " << mode.m;
    EXPECT_LE(errors.fused, kErrorTo100) << "n " << mode.n << " m " << mode.m;
    worst.grow(errors);
  }
  RecordProperty("worst_reference", std::to_string(worst.reference * 1e15) + "e-15");
  RecordProperty("worst_fused", std::to_string(worst.fused * 1e15) + "e-15");
}

TEST(Zernike, HighOrdersMatchTheFactorialSumIn200Digits) {
  const DiscPoints points = disc_points(radii(), 7, 300);
  for (const int n : {41, 60, 75, 99, 100, 150, 199, 250, 299, 300}) {
    // We test m from near zero to n, with both signs.
    std::set<int> ms;
    for (const double share : {0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0}) {
      const int m = n - 2 * int(std::lround(n * (1 - share) / 2));
      ms.insert(std::abs(m));
    }
    Errors worst;
    for (const int m : ms) {
      const ZernikeMode mode{n, (m + n / 2) % 3 == 0 ? -m : m};
      const Errors errors = errors_of(mode, points);
      const double bound = n <= 100 ? kErrorTo100 : kErrorTo300;
      EXPECT_LE(errors.reference, bound) << "n " << n << " m " << mode.m;
      EXPECT_LE(errors.fused, bound) << "n " << n << " m " << mode.m;
      worst.grow(errors);
    }
    RecordProperty("worst_reference_n" + std::to_string(n), std::to_string(worst.reference * 1e15) + "e-15");
    RecordProperty("worst_fused_n" + std::to_string(n), std::to_string(worst.fused * 1e15) + "e-15");
  }
}

TEST(Zernike, IsOrthonormalOnTheDisc) {
  // Gauss-Legendre in rho^2 times equal angles integrates products up to n = 20 exactly; weights sum to 1.
  const int n_max = 20, radial = n_max + 1, angular = 2 * n_max + 1;
  const Quadrature rule = gauss_legendre(radial, 0.0, 1.0);
  const std::vector<ZernikeMode> modes = zernike_modes(0, n_max);
  Eigen::MatrixXd basis(radial * angular, Eigen::Index(modes.size()));
  for (int i = 0; i < radial; ++i)
    for (int j = 0; j < angular; ++j) {
      const double rho = std::sqrt(rule.nodes[i]), theta = 2 * std::numbers::pi * j / angular;
      for (std::size_t k = 0; k < modes.size(); ++k)
        basis(i * angular + j, Eigen::Index(k)) =
            std::sqrt(rule.weights[i] / angular) *
            zernike(modes[k], rho * std::cos(theta), rho * std::sin(theta)).value;
    }
  const Eigen::MatrixXd gram = basis.transpose() * basis;
  // Rounding of nodes, weights and values of size <= sqrt(42): n eps and a margin; largest error 5e-15.
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Zernike, LowOrdersMatchTheirTextbookForms) {
  const double x = 0.6, y = -0.3, s = x * x + y * y;
  EXPECT_NEAR(zernike({0, 0}, x, y).value, 1.0, 1e-15);
  EXPECT_NEAR(zernike({1, 1}, x, y).value, 2 * x, 1e-15);
  EXPECT_NEAR(zernike({1, -1}, x, y).value, 2 * y, 1e-15);
  EXPECT_NEAR(zernike({2, 0}, x, y).value, std::sqrt(3.0) * (2 * s - 1), 1e-15);
  EXPECT_NEAR(zernike({2, -2}, x, y).value, std::sqrt(6.0) * 2 * x * y, 1e-15);
  EXPECT_NEAR(zernike({2, 2}, x, y).value, std::sqrt(6.0) * (x * x - y * y), 1e-15);
  EXPECT_NEAR(zernike({3, 1}, x, y).value, std::sqrt(8.0) * (3 * s - 2) * x, 1e-15);
  EXPECT_NEAR(zernike({3, -3}, x, y).value, std::sqrt(8.0) * (3 * x * x * y - y * y * y), 1e-15);
  EXPECT_NEAR(zernike({4, 0}, x, y).value, std::sqrt(5.0) * (6 * s * s - 6 * s + 1), 2e-15);
}

TEST(Zernike, RecurrenceWithoutDivisionOfTheRadialFunctionHolds) {
  // R_n^m = rho (R_{n-1}^{|m-1|} + R_{n-1}^{m+1}) - R_{n-2}^m, tested on the x axis, where cosines are R_n^m.
  const auto r = [](int n, int m, double rho) {
    return m > n ? 0.0 : zernike({n, m}, rho, 0.0).value / zernike_norm({n, m});
  };
  for (const double rho : {0.3, 0.8, 0.999})
    for (const int n : {4, 17, 60, 151, 300})
      for (int m = n % 2; m <= n; m += 14)
        EXPECT_NEAR(r(n, m, rho),
                    rho * (r(n - 1, std::abs(m - 1), rho) + r(n - 1, m + 1, rho)) - r(n - 2, m, rho),
                    4 * (n <= 100 ? kErrorTo100 : kErrorTo300));
}

TEST(Zernike, GradientAtTheVertexIsThatOfTheLinearPart) {
  // Only m = +-1 is linear at the vertex: R_n^1 = (-1)^k (k + 1) rho + ..., k = (n - 1)/2.
  for (const int n : {1, 3, 11, 101, 299}) {
    const int k = (n - 1) / 2;
    const double slope = (k % 2 == 0 ? 1.0 : -1.0) * (k + 1) * std::sqrt(2.0 * (n + 1));
    const ZernikeValue cosine = zernike({n, 1}, 0, 0), sine = zernike({n, -1}, 0, 0);
    EXPECT_NEAR(cosine.dx / slope, 1, 1e-13);
    EXPECT_NEAR(sine.dy / slope, 1, 1e-13);
    EXPECT_EQ(cosine.dy, 0);
    EXPECT_EQ(sine.dx, 0);
    EXPECT_EQ(cosine.value, 0);
  }
  for (const ZernikeMode mode :
       {ZernikeMode{0, 0}, {2, 0}, {2, 2}, {2, -2}, {30, 4}, {300, 0}, {300, -150}}) {
    const ZernikeValue at = zernike(mode, 0, 0);
    EXPECT_EQ(at.dx, 0);
    EXPECT_EQ(at.dy, 0);
    EXPECT_TRUE(std::isfinite(at.value));
  }
}

TEST(ZernikeIndex, NollFollowsTheListOfOpticStudioAndNoll) {
  const std::vector<ZernikeMode> list = {{0, 0},  {1, 1}, {1, -1}, {2, 0}, {2, -2}, {2, 2}, {3, -1}, {3, 1},
                                         {3, -3}, {3, 3}, {4, 0},  {4, 2}, {4, -2}, {4, 4}, {4, -4}};
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(zernike_from_noll(int(i) + 1), list[i]) << "j " << i + 1;
    EXPECT_EQ(noll_index(list[i]), int(i) + 1);
  }
}

TEST(ZernikeIndex, OsaFollowsItsList) {
  const std::vector<ZernikeMode> list = {{0, 0}, {1, -1}, {1, 1},  {2, -2}, {2, 0},
                                         {2, 2}, {3, -3}, {3, -1}, {3, 1},  {3, 3}};
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(zernike_from_osa(int(i)), list[i]) << "j " << i;
    EXPECT_EQ(osa_index(list[i]), int(i));
  }
}

TEST(ZernikeIndex, FringeFollowsItsList) {
  const std::vector<ZernikeMode> list = {{0, 0}, {1, 1}, {1, -1}, {2, 0}, {2, 2},  {2, -2}, {3, 1},  {3, -1},
                                         {4, 0}, {3, 3}, {3, -3}, {4, 2}, {4, -2}, {5, 1},  {5, -1}, {6, 0}};
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(zernike_from_fringe(int(i) + 1), list[i]) << "j " << i + 1;
    EXPECT_EQ(fringe_index(list[i]), int(i) + 1);
  }
}

TEST(ZernikeIndex, EverySchemeGoesThereAndBackTo40) {
  const std::vector<ZernikeMode> modes = zernike_modes(0, 40);
  std::set<int> noll, osa, fringe;
  for (const ZernikeMode mode : modes) {
    EXPECT_EQ(zernike_from_noll(noll_index(mode)), mode);
    EXPECT_EQ(zernike_from_osa(osa_index(mode)), mode);
    EXPECT_EQ(zernike_from_fringe(fringe_index(mode)), mode);
    noll.insert(noll_index(mode)), osa.insert(osa_index(mode)), fringe.insert(fringe_index(mode));
    if (mode.m != 0) {
      EXPECT_EQ(noll_index(mode) % 2 == 0, mode.m > 0);
    }
  }
  // All indices differ; Noll and OSA have no gaps.
  EXPECT_EQ(noll.size(), modes.size());
  EXPECT_EQ(fringe.size(), modes.size());
  EXPECT_EQ(*noll.begin(), 1);
  EXPECT_EQ(*noll.rbegin(), int(modes.size()));
  EXPECT_EQ(*osa.begin(), 0);
  EXPECT_EQ(*osa.rbegin(), int(modes.size()) - 1);
  for (int j = 1; j <= 1681; ++j) EXPECT_EQ(fringe_index(zernike_from_fringe(j)), j);
}

TEST(ZernikeIndex, KnowsWhereNollPutsItsLandmarks) {
  EXPECT_EQ(noll_index({4, 0}), 11);  // primary spherical
  EXPECT_EQ(noll_index({6, 0}), 22);  // secondary spherical
  EXPECT_EQ(noll_index({8, 0}), 37);
  EXPECT_EQ(zernike_from_noll(231).n, 20);  // the last of OpticStudio's Zernike Standard terms
  EXPECT_EQ(zernike_from_noll(232).n, 21);
  EXPECT_EQ(fringe_index({10, 0}), 36);  // the 37-term Fringe set ends with (12, 0)
  EXPECT_EQ(fringe_index({12, 0}), 49);
}

TEST(ZernikeIndex, RejectsWhatIsNoModeAndNoIndex) {
  for (const ZernikeMode mode : {ZernikeMode{-1, 1}, {2, 1}, {3, 5}, {3, -4}}) {
    EXPECT_FALSE(is_zernike_mode(mode));
    EXPECT_THROW(zernike(mode, 0, 0), std::invalid_argument);
    EXPECT_THROW(noll_index(mode), std::invalid_argument);
    EXPECT_THROW(osa_index(mode), std::invalid_argument);
    EXPECT_THROW(fringe_index(mode), std::invalid_argument);
  }
  EXPECT_THROW(zernike_from_noll(0), std::invalid_argument);
  EXPECT_THROW(zernike_from_osa(-1), std::invalid_argument);
  EXPECT_THROW(zernike_from_fringe(0), std::invalid_argument);
}
