// Very many terms in one operator, and points beyond the rim of the Zernikes. The truth is a long-double sum
// of single modes by zernike_at, which has a recurrence of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/random.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kRadius = 0.2;
constexpr double kPromised = 1e-11;  // zernike.h: of each mode, n <= 300

TermSet zernikes_to(int n_max) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(0, n_max);
  return terms;
}

struct PlainSums {
  long double height = 0, slope_x = 0;
};
PlainSums plain(const TermSet& terms, const Eigen::VectorXd& c, double x, double y) {
  PlainSums sum;
  const long double u = (long double)(x) / kRadius, v = (long double)(y) / kRadius;
  for (std::size_t j = 0; j < terms.zernike.size(); ++j) {
    const auto z = zernike_at<long double>(terms.zernike[j], u, v);
    sum.height += c[Eigen::Index(j)] * z.value;
    sum.slope_x += c[Eigen::Index(j)] * z.dx / kRadius;
  }
  return sum;
}

// Largest relative error of heights and slopes at a few points, and of the adjoint, <L c, g> - <c, L^T g>
// over |L c| |g|.
double error_of(const SurfaceOperator& surface, const PupilSample& pupil) {
  const Eigen::VectorXd c = draw_white(surface.terms().size(), 1);
  SurfaceField field;
  surface.apply(c, &field);
  double error = 0;
  const double rms = std::sqrt(field.height.square().mean()),
               rms_slope = std::sqrt(field.slope_x.square().mean());
  for (Eigen::Index i = 0; i < pupil.size(); i += pupil.size() / 7) {
    const PlainSums truth = plain(surface.terms(), c, pupil.x[i], pupil.y[i]);
    error = std::max({error, double(std::abs(field.height[i] - truth.height)) / rms,
                      double(std::abs(field.slope_x[i] - truth.slope_x)) / rms_slope});
  }
  SurfaceField weights = field;
  weights.height.reverseInPlace();
  weights.slope_y.reverseInPlace();
  const double there =
      (field.height * weights.height + field.slope_x * weights.slope_x + field.slope_y * weights.slope_y)
          .sum();
  const double size = (field.height.square() + field.slope_x.square() + field.slope_y.square()).sum();
  return std::max(error, std::abs(c.dot(surface.apply_transpose(weights)) - there) / size);
}

// n = 140 gives 10,011 terms; no matrix is stored.
TEST(ManyTerms, AreAsExactAsFew) {
  const PupilSample pupil = make_pupil(CircleAperture{2 * kRadius, 0}, {PupilLayout::kPolar, 8192, 1});
  for (const int n_max : {2, 8, 20, 40, 80, 140})
    for (const ZernikeMethod method : {ZernikeMethod::kPolar, ZernikeMethod::kFused})
      EXPECT_LT(error_of(SurfaceOperator(zernikes_to(n_max), pupil, {1, method, {}}), pupil), kPromised)
          << n_max << to_string(method);
}

// At rho > 1 the polynomials grow as (rho + sqrt(rho^2 - 1))^n; `hold_at_rim` is the guard.
TEST(StabilityEdge, ZernikesBeyondTheRim) {
  Edge edge("zernikes_beyond_the_rim", "radial order n at rho = 1.007 [1]",
            "largest |height| / that at the rim [1]");
  constexpr double kBeyond = 1.007;
  for (int n = 4; n <= 100; n += 8) {
    TermSet terms;
    terms.radius = kRadius;
    terms.zernike = {{n, 0}};
    PupilSample point;
    point.x = Eigen::ArrayXd::Constant(1, kBeyond * kRadius), point.y = Eigen::ArrayXd::Zero(1);
    point.weight = Eigen::ArrayXd::Ones(1);
    SurfaceField held, grown;
    OperatorOptions options;
    SurfaceOperator(terms, point, options).apply(Eigen::VectorXd::Ones(1), &grown);
    options.hold_at_rim = true;
    SurfaceOperator(terms, point, options).apply(Eigen::VectorXd::Ones(1), &held);
    const double rim = std::sqrt(n + 1.0);
    edge.add({double(n), std::abs(held.height[0]) / rim, 1 + 1e-12, false, std::abs(grown.height[0]) / rim});
  }
  // Legendre's P_n(cosh a) resembles I_0 at first, and e^(n a)/sqrt(2 pi n sinh a) later.
  const double a =
      std::log(kBeyond * kBeyond * 2 - 1 + std::sqrt(std::pow(2 * kBeyond * kBeyond - 1, 2) - 1)) / 2;
  edge.follows({"(rho + sqrt(rho^2-1))^n / sqrt(pi n sqrt(rho^2-1) rho)",
                [a](double n) {
                  const double root = std::sqrt(kBeyond * kBeyond - 1);
                  return std::exp(a * (n + 1)) / std::sqrt(std::numbers::pi * (n + 1) * 2 * root * kBeyond);
                },
                20, 100, 1.1});
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
