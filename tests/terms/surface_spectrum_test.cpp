#include "aberfit/terms/surface_spectrum.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kRadius = 0.2;
// The central difference of a quadratic is exact except for rounding.
constexpr double kDifference = 1e-8;

TermSet zernikes(int n_min, int n_max) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(n_min, n_max);
  return terms;
}

Eigen::VectorXd draw(Eigen::Index size, const char* name) {
  const RandomStream stream(1, name);
  Eigen::VectorXd c(size);
  for (Eigen::Index j = 0; j < size; ++j) c[j] = 1e-8 * stream.normal(std::uint64_t(j));
  return c;
}

void expect_jacobian(const SurfaceSpectrum& spectrum, const Eigen::VectorXd& c) {
  Eigen::VectorXd values, plus, minus;
  Eigen::MatrixXd jacobian;
  spectrum.evaluate(c, &values, &jacobian);
  ASSERT_EQ(jacobian.rows(), spectrum.bins());
  ASSERT_EQ(jacobian.cols(), c.size());
  const double step = 0.1 * c.lpNorm<Eigen::Infinity>();
  for (Eigen::Index j = 0; j < c.size(); ++j) {
    Eigen::VectorXd moved = c;
    moved[j] = c[j] + step;
    spectrum.evaluate(moved, &plus, nullptr);
    moved[j] = c[j] - step;
    spectrum.evaluate(moved, &minus, nullptr);
    const Eigen::VectorXd difference = (plus - minus) / (2 * step);
    for (Eigen::Index b = 0; b < spectrum.bins(); ++b)
      EXPECT_NEAR(jacobian(b, j), difference[b], kDifference * jacobian.row(b).lpNorm<Eigen::Infinity>())
          << b << " " << j;
  }
}

}  // namespace

TEST(ZernikeSpectrum, IntegratesToTheSquareOfTheCoefficients) {
  const TermSet terms = zernikes(0, 8);
  const Eigen::VectorXd c = draw(terms.size(), "parseval");
  const double kappa = 4000, to_kappa = 2 * pi * kRadius;
  Eigen::ArrayXd low(3), high(3);
  low << 0, 5 / to_kappa, 80 / to_kappa;
  high << 5 / to_kappa, 80 / to_kappa, kappa / to_kappa;
  Eigen::VectorXd values;
  zernike_spectrum(terms, low, high)->evaluate(c, &values, nullptr);
  double sum = (pi * (high.square() - low.square()) * values.array()).sum();
  // Beyond, J J ~ 1/(pi kappa) on average: the step at the rim lacks 2/(pi kappa) |sum sqrt(n+1) a|^2 per m.
  for (int m = -8; m <= 8; ++m) {
    double rim = 0;
    for (Eigen::Index j = 0; j < c.size(); ++j)
      if (terms.zernike[std::size_t(j)].m == m)
        rim += std::sqrt(terms.zernike[std::size_t(j)].n + 1.0) * c[j];
    sum += 2 / (pi * kappa) * rim * rim;
  }
  // The next order is (n + 1)^2/kappa^2.
  EXPECT_NEAR(sum / c.squaredNorm(), 1, 2e-5);
}

TEST(ZernikeSpectrum, IsTheFourierIntegralOverTheDiscAveragedOverDirections) {
  const TermSet terms = zernikes(1, 9);
  const Eigen::VectorXd c = draw(terms.size(), "fourier-integral");
  const double to_kappa = 2 * pi * kRadius;
  Eigen::ArrayXd low(4), high(4);
  low << 0, 2 / to_kappa, 7 / to_kappa, 20 / to_kappa;
  high << 2 / to_kappa, 3 / to_kappa, 10 / to_kappa, 28 / to_kappa;
  Eigen::VectorXd values;
  const auto spectrum = zernike_spectrum(terms, low, high);
  ASSERT_EQ(spectrum->bins(), 4);
  spectrum->evaluate(c, &values, nullptr);
  // The surface on a polar rule that is exact for its degree and for waves up to kappa = 28.
  const Quadrature radial = gauss_legendre(36, 0, 1);
  const int angles = 96;
  std::vector<double> x, y, wh;
  for (int i = 0; i < 36; ++i)
    for (int a = 0; a < angles; ++a) {
      const double rho = radial.nodes[i], t = 2 * pi * a / angles;
      double h = 0;
      for (Eigen::Index j = 0; j < c.size(); ++j)
        h += c[j] * zernike(terms.zernike[std::size_t(j)], rho * std::cos(t), rho * std::sin(t)).value;
      x.push_back(kRadius * rho * std::cos(t));
      y.push_back(kRadius * rho * std::sin(t));
      wh.push_back(h * kRadius * kRadius * rho * radial.weights[i] * 2 * pi / angles);
    }
  for (Eigen::Index b = 0; b < 4; ++b) {
    const Quadrature rule = gauss_legendre(16, low[b], high[b]);
    double sum = 0, weight = 0;
    for (int q = 0; q < 16; ++q) {
      const double f = rule.nodes[q];
      const int directions = 20;  // |H|^2 is even and has angular orders up to 18
      for (int d = 0; d < directions; ++d) {
        const double fx = f * std::cos(pi * d / directions), fy = f * std::sin(pi * d / directions);
        std::complex<double> H = 0;
        for (std::size_t i = 0; i < x.size(); ++i) H += std::polar(wh[i], -2 * pi * (fx * x[i] + fy * y[i]));
        sum += rule.weights[q] * f * std::norm(H) / (pi * kRadius * kRadius) / directions;
      }
      weight += rule.weights[q] * f;
    }
    EXPECT_NEAR(values[b] / (sum / weight), 1, 1e-10) << b;
  }
}

TEST(ZernikeSpectrum, JacobianIsThatOfAQuadratic) {
  const TermSet terms = zernikes(2, 12);
  Eigen::ArrayXd low(3), high(3);
  low << 1, 6, 30;
  high << 2, 11, 60;
  const auto spectrum = zernike_spectrum(terms, low, high);
  const Eigen::VectorXd c = draw(terms.size(), "zernike-jacobian");
  expect_jacobian(*spectrum, c);
  expect_jacobian(*spectrum, 1e-3 * c);
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  spectrum->evaluate(c, &values, &jacobian);
  // Euler's theorem for quadratics.
  EXPECT_LE((jacobian * c - 2 * values).lpNorm<Eigen::Infinity>(), 1e-13 * values.maxCoeff());
}

TEST(ZernikeSpectrum, MeanOverThePriorIsThePsdSeenThroughTheDisc) {
  // All modes that the PSD excites: l f < 2 covers S down to exp(-39).
  const TermSet terms = zernikes(0, 44);
  const double l = 0.4 * kRadius;
  const RadialPsd psd(GaussianPsd{1e-8, l});
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  const Eigen::ArrayXd f = Eigen::ArrayXd::LinSpaced(6, 0.1, 1.2) / l;
  const Eigen::ArrayXd low = f * (1 - 1e-4), high = f * (1 + 1e-4);
  const auto spectrum = zernike_spectrum(terms, low, high);
  // E Q(F xi) is the sum of Q over the columns of F.
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(f.size()), values;
  for (Eigen::Index j = 0; j < terms.size(); ++j) {
    spectrum->evaluate(prior.colour(Eigen::VectorXd::Unit(terms.size(), j)), &values, nullptr);
    mean += values;
  }
  // PSD convolved with |transform of the disc|^2: transform of the ACF times the overlap of two discs.
  const Quadrature rule = gauss_legendre(200, 0, pi / 2);
  for (Eigen::Index b = 0; b < f.size(); ++b) {
    double truth = 0;
    for (int i = 0; i < 200; ++i) {
      const double t = std::sin(rule.nodes[i]), r = 2 * kRadius * t;  // removes the root at t = 1
      const double overlap = 2 / pi * (std::acos(t) - t * std::sqrt(1 - t * t));
      truth += rule.weights[i] * 2 * kRadius * std::cos(rule.nodes[i]) * 2 * pi * r * overlap * 1e-16 *
               std::exp(-r * r / (l * l)) * boost::math::cyl_bessel_j(0, 2 * pi * f[b] * r);
    }
    EXPECT_NEAR(mean[b] / truth, 1, 1e-6) << f[b] * l;
  }
}

TEST(ZernikeSpectrum, RefusesOtherTermsAndBadBins) {
  TermSet terms = zernikes(2, 4);
  const Eigen::ArrayXd low = Eigen::ArrayXd::Constant(1, 1.0), high = Eigen::ArrayXd::Constant(1, 2.0);
  EXPECT_THROW(zernike_spectrum(terms, high, low), std::invalid_argument);
  EXPECT_THROW(zernike_spectrum(terms, low, Eigen::ArrayXd(0)), std::invalid_argument);
  terms.fourier = {{1, 1}};
  EXPECT_THROW(zernike_spectrum(terms, low, high), std::invalid_argument);
  terms = zernikes(2, 4);
  terms.spherical = {4};
  EXPECT_THROW(zernike_spectrum(terms, low, high), std::invalid_argument);
  terms = zernikes(2, 4);
  terms.zernike.push_back({3, 2});
  EXPECT_THROW(zernike_spectrum(terms, low, high), std::invalid_argument);
}

namespace {

TermSet mixed() {
  TermSet terms = zernikes(2, 6);
  terms.fourier = {{9, 4}, {-17, 22}};
  terms.spherical = {4, 8};
  return terms;
}

// The definition on a small grid: monomials by least squares, Hann window, sums, means over [low, high).
Eigen::VectorXd plain_estimate(const TermSet& terms, const Eigen::VectorXd& c, int n, int degree,
                               const Eigen::ArrayXd& low, const Eigen::ArrayXd& high) {
  const double pitch = std::sqrt(2.0) * kRadius / n;
  Eigen::ArrayXd x(n * n), y(n * n), window(n * n);
  for (int i = 0; i < n * n; ++i) {
    x[i] = -kRadius / std::sqrt(2.0) + (i % n + 0.5) * pitch;
    y[i] = -kRadius / std::sqrt(2.0) + (i / n + 0.5) * pitch;
    window[i] = std::pow(std::sin(pi * (i % n + 0.5) / n) * std::sin(pi * (i / n + 0.5) / n), 2);
  }
  SurfaceField field;
  SurfaceOperator(terms, x, y).apply(c, &field);
  Eigen::MatrixXd shapes(n * n, (degree + 1) * (degree + 2) / 2);
  for (int total = 0, column = 0; total <= degree; ++total)
    for (int j = 0; j <= total; ++j)
      shapes.col(column++) = (x / kRadius).pow(total - j) * (y / kRadius).pow(j);
  const Eigen::VectorXd z = field.height.matrix();
  const Eigen::ArrayXd w = window * (z - shapes * LeastSquares(shapes).solve(z)).array();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(low.size()), count = sum;
  for (int k = -(n - 1) / 2; k <= n / 2; ++k)
    for (int l = -(n - 1) / 2; l <= n / 2; ++l) {
      const double f = std::hypot(k, l) / (n * pitch);
      for (Eigen::Index b = 0; b < low.size(); ++b) {
        if (f < low[b] || f >= high[b] * (1 - 1e-8)) continue;
        std::complex<double> F = 0;
        for (int i = 0; i < n * n; ++i)
          F += std::polar(w[i], -2 * pi * (k * (i % n) + l * (i / n)) / double(n));
        sum[b] += std::norm(F) * pitch * pitch / window.square().sum();
        count[b] += 1;
      }
    }
  return sum.cwiseQuotient(count);
}

}  // namespace

TEST(EstimatedSpectrum, IsTheBinnedPeriodogramOfTheDetrendedWindowedSurface) {
  const TermSet terms = mixed();
  const Eigen::VectorXd c = draw(terms.size(), "estimated-values");
  for (const int n : {15, 24})
    for (const int degree : {0, 2, 3}) {
      PsdEstimatorOptions options;
      options.detrend.degree = degree;
      options.bins_per_decade = 6;
      Eigen::ArrayXd low, high;
      const auto spectrum = estimated_spectrum(terms, options, n, 1, &low, &high);
      ASSERT_EQ(low.size(), spectrum->bins());
      EXPECT_GT(spectrum->bins(), 3);
      Eigen::VectorXd values;
      spectrum->evaluate(c, &values, nullptr);
      const Eigen::VectorXd truth = plain_estimate(terms, c, n, degree, low, high);
      for (Eigen::Index b = 0; b < values.size(); ++b)
        EXPECT_NEAR(values[b] / truth[b], 1, 1e-11) << n << " " << b;
    }
}

TEST(EstimatedSpectrum, JacobianIsThatOfAQuadraticForEveryWindow) {
  const TermSet terms = mixed();
  const Eigen::VectorXd c = draw(terms.size(), "estimated-jacobian");
  for (const WindowKind window : {WindowKind::kNone, WindowKind::kHann, WindowKind::kBlackmanHarris,
                                  WindowKind::kTukey, WindowKind::kHamming, WindowKind::kWelch}) {
    PsdEstimatorOptions options;
    options.window = window;
    Eigen::ArrayXd low, high;
    const auto spectrum = estimated_spectrum(terms, options, 30, 1, &low, &high);
    expect_jacobian(*spectrum, c);
  }
}

TEST(EstimatedSpectrum, DoesNotDependOnTheThreadsAndRefusesSmallGrids) {
  const TermSet terms = mixed();
  const Eigen::VectorXd c = draw(terms.size(), "estimated-threads");
  Eigen::ArrayXd low, high;
  Eigen::VectorXd one, two;
  Eigen::MatrixXd jacobian_one, jacobian_two;
  estimated_spectrum(terms, {}, 48, 1, &low, &high)->evaluate(c, &one, &jacobian_one);
  estimated_spectrum(terms, {}, 48, 3, &low, &high)->evaluate(c, &two, &jacobian_two);
  EXPECT_TRUE(one == two);
  EXPECT_TRUE(jacobian_one == jacobian_two);
  EXPECT_THROW(estimated_spectrum(terms, {}, 3, 1, &low, &high), std::invalid_argument);
}

TEST_WITH_SHORT_FORM(EstimatedSpectrum, AgreesWithTheEstimatorItself) {
  // Relative to the strongest bin, because the rounding of a transform scales with it. Bins that a window
  // such as Blackman-Harris makes very weak differ by up to 1.5e-9 of their value.
  constexpr double kRounding = 1e-12;
  const TermSet terms = mixed();
  const Eigen::VectorXd c = draw(terms.size(), "estimator-itself");
  int setting = 0;
  for (const int n : {16, 30, 48, 66})
    for (const WindowKind window : {WindowKind::kNone, WindowKind::kHann, WindowKind::kTukey,
                                    WindowKind::kBlackmanHarris, WindowKind::kWelch, WindowKind::kHamming})
      for (const int degree : {0, 2, 4}) {
        if (!whole && ++setting % 5 != 0) continue;
        PsdEstimatorOptions options;
        options.window = window;
        options.find_lines = false;
        options.detrend.degree = degree;
        Eigen::ArrayXd low, high;
        Eigen::VectorXd values;
        estimated_spectrum(terms, options, n, 1, &low, &high)->evaluate(c, &values, nullptr);
        HeightMap map;
        map.pitch_x = map.pitch_y = std::sqrt(2.0) * kRadius / n;
        map.x0 = map.y0 = -0.5 * (n - 1) * map.pitch_x;
        Eigen::ArrayXd x(n * n), y(n * n);
        for (int i = 0; i < n * n; ++i) x[i] = map.x(i % n), y[i] = map.y(i / n);
        SurfaceField field;
        SurfaceOperator(terms, x, y).apply(c, &field);
        map.height = Eigen::Map<const Grid>(field.height.data(), n, n);
        const PsdEstimate estimate = estimate_psd(map, options);
        ASSERT_EQ(estimate.psd.size(), values.size());
        EXPECT_LE((estimate.psd - values.array()).abs().maxCoeff(), kRounding * values.maxCoeff())
            << n << " " << to_string(window) << " " << degree;
        EXPECT_TRUE(low.isApprox(estimate.low, 1e-14) && high.isApprox(estimate.high, 1e-14));
      }
}
