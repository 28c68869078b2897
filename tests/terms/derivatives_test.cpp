#include "aberfit/terms/derivatives.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/scene/zernike.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;
constexpr double kExpansion = 1e-11;  // relative to the largest value, from the header

// d2Z/dxdy with 100 digits: Z = norm u q(t), u = Re or Im (x + iy)^m, t = x^2 + y^2, q the factorial sum.
Exact exact_cross(ZernikeMode mode, double px, double py) {
  const int m = std::abs(mode.m), n = mode.n, k = (n - m) / 2;
  const Exact x = px, y = py, t = x * x + y * y;
  std::vector<Exact> factorial(std::size_t(n) + 1, 1);
  for (int i = 1; i <= n; ++i) factorial[std::size_t(i)] = factorial[std::size_t(i) - 1] * i;
  const auto f = [&](int i) { return factorial[std::size_t(i)]; };
  Exact q = 0, q1 = 0, q2 = 0;
  for (int s = k; s >= 0; --s) {  // powers 0 .. k of t
    const int p = k - s;
    const Exact a = (s % 2 ? -1 : 1) * f(n - s) / (f(s) * f((n + m) / 2 - s) * f(k - s));
    Exact power = 1;
    for (int i = 0; i + 2 < p; ++i) power *= t;  // t^(p-2)
    q += a * (p >= 2 ? power * t * t : p == 1 ? t : Exact(1));
    if (p >= 1) q1 += a * p * (p >= 2 ? power * t : Exact(1));
    if (p >= 2) q2 += a * p * (p - 1) * power;
  }
  // Powers of w = x + iy; w^j for j < 0 has a zero factor.
  Exact re = 1, im = 0;
  std::vector<std::array<Exact, 2>> w = {{Exact(1), Exact(0)}};
  for (int i = 0; i < m; ++i) {
    const Exact next = re * x - im * y;
    im = re * y + im * x;
    re = next;
    w.push_back({re, im});
  }
  const auto part = [&](int power, bool times_i) {
    if (power < 0) return Exact(0);
    const auto& v = w[std::size_t(power)];
    if (mode.m < 0) return times_i ? v[0] : v[1];
    return times_i ? Exact(-v[1]) : v[0];
  };
  const Exact u = part(m, false), ux = m * part(m - 1, false), uy = m * part(m - 1, true),
              uxy = m * (m - 1) * part(m - 2, true);
  return zernike_norm(mode) * (uxy * q + 2 * y * ux * q1 + 2 * x * uy * q1 + 4 * x * y * u * q2);
}

struct Points {
  Eigen::ArrayXd x, y;
};
Points points(double radius) {
  std::vector<std::pair<double, double>> at = {{0, 0}, {1e-9, -1e-9}, {1, 0}, {0, -1}};
  for (const double rho : {0.3, 0.9, 0.99, 1.0})
    for (int i = 0; i < 7; ++i) at.emplace_back(rho * std::cos(0.3 + 0.9 * i), rho * std::sin(0.3 + 0.9 * i));
  Points p{Eigen::ArrayXd(Eigen::Index(at.size())), Eigen::ArrayXd(Eigen::Index(at.size()))};
  for (Eigen::Index i = 0; i < p.x.size(); ++i)
    p.x[i] = radius * at[std::size_t(i)].first, p.y[i] = radius * at[std::size_t(i)].second;
  return p;
}

}  // namespace

TEST(CrossDerivative, OfSingleZernikesMatchesAHundredDigits) {
  const Points p = points(1.0);
  for (const ZernikeMode mode : std::vector<ZernikeMode>{
           {0, 0}, {1, 1},  {1, -1}, {2, 0},    {2, -2}, {2, 2},  {3, 1},   {3, -1},  {4, 0},    {5, -3},
           {9, 9}, {30, 0}, {31, 1}, {45, -23}, {60, 0}, {60, 2}, {60, -2}, {60, 60}, {59, -57}, {60, 30}}) {
    TermSet terms;
    terms.radius = 1;
    terms.zernike = {mode};
    const Eigen::ArrayXd value = cross_derivative(terms, Eigen::VectorXd::Ones(1), p.x, p.y);
    Eigen::ArrayXd truth(value.size());
    for (Eigen::Index i = 0; i < value.size(); ++i) truth[i] = double(exact_cross(mode, p.x[i], p.y[i]));
    EXPECT_LE((value - truth).abs().maxCoeff(), kExpansion * truth.abs().maxCoeff())
        << mode.n << " " << mode.m;
  }
}

TEST(CrossDerivative, OfAWholeSetUpToOrderSixtyMatchesAHundredDigits) {
  const double R = 0.2;
  TermSet terms;
  terms.radius = R;
  terms.zernike = zernike_modes(0, 60);
  const RandomStream stream(1, "cross-derivative-test");
  Eigen::VectorXd c(terms.size());
  for (Eigen::Index j = 0; j < c.size(); ++j) c[j] = 1e-8 * stream.normal(std::uint64_t(j));
  Points p = points(R);
  p.x = p.x.head(14).eval(), p.y = p.y.head(14).eval();
  const Eigen::ArrayXd value = cross_derivative(terms, c, p.x, p.y);
  Eigen::ArrayXd truth(value.size());
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    Exact sum = 0;
    for (std::size_t j = 0; j < terms.zernike.size(); ++j)
      sum += c[Eigen::Index(j)] * exact_cross(terms.zernike[j], p.x[i] / R, p.y[i] / R);
    truth[i] = double(sum) / (R * R);
  }
  EXPECT_LE((value - truth).abs().maxCoeff(), kExpansion * truth.abs().maxCoeff());
}

TEST(CrossDerivative, OfWavesAndSphericalTermsMatchesTheirClosedForms) {
  TermSet terms;
  terms.radius = 0.2;
  terms.zernike = {{2, -2}};
  terms.fourier = {{3, -7}, {0, 40}, {25, 0}};
  terms.spherical = {4, 6, 8, 10, 12};
  Eigen::VectorXd c(terms.size());
  for (Eigen::Index j = 0; j < c.size(); ++j) c[j] = 1e-8 * double(j + 1);
  const Points p = points(terms.radius);
  const Eigen::ArrayXd value = cross_derivative(terms, c, p.x, p.y);
  // Z_2^-2 = 2 sqrt(6) x y / R^2.
  Eigen::ArrayXd truth = Eigen::ArrayXd::Constant(p.x.size(), c[0] * 2 * std::sqrt(6.0) / 0.04);
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::ArrayXd phase = 2 * pi * (terms.fourier[k].fx * p.x + terms.fourier[k].fy * p.y);
    const double ff = 4 * pi * pi * terms.fourier[k].fx * terms.fourier[k].fy;
    truth -= ff * (c[1 + 2 * Eigen::Index(k)] * phase.cos() + c[2 + 2 * Eigen::Index(k)] * phase.sin());
  }
  for (Eigen::Index i = 0; i < p.x.size(); ++i)
    for (int k = 0; k < 5; ++k) {
      const int power = 4 + 2 * k;
      const double rho = std::hypot(p.x[i], p.y[i]);
      truth[i] +=
          c[7 + k] * power * (power - 2) * p.x[i] * p.y[i] * std::pow(rho, power - 4) / std::pow(0.2, power);
    }
  EXPECT_LE((value - truth).abs().maxCoeff(), 1e-13 * truth.abs().maxCoeff());
}

TEST(CrossDerivative, OfNoTermsIsZero) {
  TermSet terms;
  terms.radius = 1;
  const Points p = points(1.0);
  EXPECT_TRUE((cross_derivative(terms, Eigen::VectorXd(0), p.x, p.y) == 0).all());
}
