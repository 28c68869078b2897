#include "aberfit/roughness/random_surface.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aberfit/roughness/k_correlation.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kProfile = 1e-9;  // relative to S1, from the header
// Cells beyond the eighth have two nodes per side. The largest error is 6.4e-7 of the variance.
constexpr double kCells = 1e-5;

struct Size {
  Eigen::Index rows, columns;
};
const std::vector<Size> kSizes = {{32, 32}, {31, 31}, {33, 20}, {20, 33}, {16, 45}, {27, 9}};

double mean_square(const Grid& height) { return height.square().mean(); }

// Mean and its standard error.
struct Sample {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt((squares / count - mean() * mean()) / (count - 1)); }
};

// int_a^b g df by the tanh-sinh rule, which allows square-root ends.
template <class F>
double integrated(const F& g, double a, double b) {
  boost::math::quadrature::tanh_sinh<double> rule;
  const double half = 0.5 * (b - a), middle = 0.5 * (a + b);
  return half * rule.integrate([&](double t) { return g(middle + half * t); }, -1.0, 1.0, 1e-11);
}

// Mean of S over one cell of the frequency grid, by many midpoints.
double cell_mean(const RadialPsd& psd, double fx, double fy, double dx, double dy) {
  constexpr int n = 60;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      sum += psd(std::hypot(fx + dx * ((i + 0.5) / n - 0.5), fy + dy * ((j + 0.5) / n - 0.5)));
  return sum / (n * n);
}

}  // namespace

TEST(RandomSurface, MeanPeriodogramOfPeriodicDrawsIsThePsdAtEveryOrdinate) {
  const double pitch = 0.01;
  const int draws = 1000;
  const RadialPsd psd(PowerLawPsd{{}, 1e-18, 1.5, 0, 1e4});
  for (const Size size : std::vector<Size>{{8, 8}, {9, 9}, {7, 10}, {10, 7}}) {
    const Eigen::Index M = size.rows, N = size.columns;
    const double dx = 1 / (double(N) * pitch), dy = 1 / (double(M) * pitch);
    Eigen::MatrixXcd fx(N, N), fy(M, M);
    for (Eigen::Index a = 0; a < N; ++a)
      for (Eigen::Index b = 0; b < N; ++b)
        fx(a, b) = std::polar(1.0 / double(N), -2 * pi * double(a * b) / double(N));
    for (Eigen::Index a = 0; a < M; ++a)
      for (Eigen::Index b = 0; b < M; ++b)
        fy(a, b) = std::polar(1.0 / double(M), -2 * pi * double(a * b) / double(M));
    Eigen::ArrayXXd periodogram = Eigen::ArrayXXd::Zero(M, N);
    for (int seed = 0; seed < draws; ++seed) {
      const HeightMap map = random_surface(psd, M, N, pitch, {std::uint64_t(seed), 1});
      periodogram += (fy * map.height.matrix() * fx).array().abs2() / (dx * dy * draws);
    }
    for (Eigen::Index j = 0; j < M; ++j)
      for (Eigen::Index k = 0; k < N; ++k) {
        const bool own_mirror = (2 * j) % M == 0 && (2 * k) % N == 0;
        if (j == 0 && k == 0) {
          EXPECT_LT(periodogram(0, 0), 1e-30 * periodogram.maxCoeff());
          continue;
        }
        const double f_x = double(std::min(k, N - k)) * dx, f_y = double(std::min(j, M - j)) * dy;
        // The frequency cell of a Nyquist ordinate consists of the inner halves of two cells.
        const bool edge_x = 2 * k == N, edge_y = 2 * j == M;
        const double truth = cell_mean(psd, f_x - 0.25 * dx * edge_x, f_y - 0.25 * dy * edge_y,
                                       dx * (edge_x ? 0.5 : 1), dy * (edge_y ? 0.5 : 1));
        // 4.5 standard errors for some 300 ordinates; each realisation is chi-squared with 1 or 2 degrees.
        const double error = std::sqrt((own_mirror ? 2.0 : 1.0) / draws);
        EXPECT_NEAR(periodogram(j, k) / truth, 1, 4.5 * error) << M << " x " << N << ": " << j << " " << k;
      }
  }
}

TEST_WITH_SHORT_FORM(RandomSurface, MeanVarianceIsThatOfTheBandForEveryShapeAndCutOut) {
  const double pitch = 0.002;
  for (const Size size : kSizes)
    for (const int oversize : {1, 2}) {
      const double shortest = double(std::min(size.rows, size.columns)) * pitch * oversize;
      const RadialPsd psd(PowerLawPsd{1e-7, {}, 2.5, 0.8 / shortest, 0.49 / pitch});
      Sample variance;
      for (int seed = 0; seed < (whole ? 1000 : 200); ++seed)
        variance.add(mean_square(
            random_surface(psd, size.rows, size.columns, pitch, {std::uint64_t(seed), oversize}).height));
      EXPECT_NEAR(variance.mean(), psd_moments(psd).height_variance, 3 * variance.error())
          << size.rows << " x " << size.columns << ", oversize " << oversize;
    }
}

TEST(RandomSurface, SameSeedSameBitsOtherSeedOtherSurface) {
  const RadialPsd psd(GaussianPsd{1e-8, 0.01});
  RandomSurfaceOptions options;
  const HeightMap first = random_surface(psd, 21, 40, 0.001, options),
                  again = random_surface(psd, 21, 40, 0.001, options);
  EXPECT_TRUE((first.height == again.height).all());
  options.seed = 2;
  EXPECT_GT((random_surface(psd, 21, 40, 0.001, options).height - first.height).abs().maxCoeff(), 1e-9);
  EXPECT_DOUBLE_EQ(first.x(0), -first.x(39));
  EXPECT_DOUBLE_EQ(first.y(0), -first.y(20));
}

TEST(RandomSurface, RefusesWhatIsNoGrid) {
  const RadialPsd psd(GaussianPsd{1e-8, 0.01});
  EXPECT_THROW(random_surface(psd, 0, 4, 0.001), std::invalid_argument);
  EXPECT_THROW(random_surface(psd, 4, 4, 0), std::invalid_argument);
  EXPECT_THROW(random_surface(psd, 4, 4, 0.001, {1, 0}), std::invalid_argument);
  EXPECT_THROW(random_profile(psd, 4, 0.001, {1, 0}), std::invalid_argument);
}

TEST(ProfilePsd, MatchesClosedForms) {
  const double s = 1e-7;
  // Power law without a band limit: int (f^2 + y^2)^(-p/2) dy = f^(1-p) sqrt(pi) Gamma((p-1)/2) / Gamma(p/2).
  for (const double p : {1.2, 2.0, 3.7}) {
    const RadialPsd psd(PowerLawPsd{{}, 1e-18, p, 0, kInf});
    for (const double f : {1e-3, 1.0, 7.0, 1e6}) {
      const double truth =
          2e-18 * std::pow(f, 1 - p) * std::sqrt(pi) * std::tgamma(0.5 * (p - 1)) / std::tgamma(0.5 * p);
      EXPECT_NEAR(profile_psd(psd, f) / truth, 1, kProfile) << p << " " << f;
    }
  }
  const double l = 0.01, B = 0.03;
  const RadialPsd gaussian(GaussianPsd{s, l});
  const RadialPsd k(KCorrelationPsd{s, B, 2.7, 0, kInf});
  const KCorrelation1d k1 = k_correlation_2d_to_1d({k(0), B, 2.7});
  for (const double f : {0.01, 1.0, 30.0, 150.0, 400.0}) {
    EXPECT_NEAR(
        profile_psd(gaussian, f) / (2 * s * s * l * std::sqrt(pi) * std::exp(-std::pow(pi * l * f, 2))), 1,
        kProfile);
    EXPECT_NEAR(profile_psd(k, f) / (k1.amplitude * std::pow(1 + B * B * f * f, -0.5 * k1.exponent)), 1,
                kProfile);
  }
  const double a = 3, b = 50;
  const RadialPsd uniform(UniformPsd{s, a, b});
  const double level = s * s / (pi * (b * b - a * a));
  for (const double f : {0.1, 2.999, 3.0, 3.001, 20.0, 49.999}) {
    const double truth = 4 * level * (std::sqrt(b * b - f * f) - std::sqrt(std::max(0.0, a * a - f * f)));
    EXPECT_NEAR(profile_psd(uniform, f) / truth, 1, kProfile) << f;
  }
  EXPECT_EQ(profile_psd(uniform, 50), 0);
  EXPECT_EQ(profile_psd(RadialPsd(PowerLawPsd{{}, 1e-18, 1.0, 0, kInf}), 1.0), kInf);
}

TEST(ProfilePsd, MatchesAdaptiveQuadratureForTablesAndBands) {
  TablePsd table;
  for (int i = 0; i < 12; ++i) {
    table.frequency.push_back(2 * std::pow(1.6, i));
    table.psd.push_back(1e-17 * std::pow(table.frequency.back(), -1.5) * (1 + 0.5 * std::sin(7.0 * i)));
  }
  const std::vector<PsdModel> models = {KCorrelationPsd{1e-7, 0.1, 2.4, 1, 1e4},
                                        PowerLawPsd{1e-7, {}, 2.4, 1, 1e4}, table,
                                        SumPsd{{UniformPsd{1e-7, 2, 40}, table}}};
  boost::math::quadrature::tanh_sinh<double> rule;
  for (const PsdModel& model : models) {
    const RadialPsd psd(model);
    for (const double f : {0.3, 1.5, 2.3, 17.0, 300.0}) {
      if (f >= psd.f_max()) continue;
      double truth = 0, from = std::max(f, psd.f_min());
      for (const double bend : psd.breakpoints()) {
        if (bend <= from) continue;
        // In v = sqrt(g - f): S(f + v^2) (f + v^2) 2 / sqrt(2 f + v^2).
        truth += rule.integrate(
            [&](double v) {
              const double g = std::min(bend, std::max(from, f + v * v));
              return psd(g * (g == bend ? 1 - 1e-15 : 1)) * g * 2 / std::sqrt(g + f);
            },
            std::sqrt(from - f), std::sqrt(bend - f), 1e-13);
        from = bend;
      }
      EXPECT_NEAR(profile_psd(psd, f) / (4 * truth), 1, kProfile) << f;
    }
  }
}

TEST(ProfilePsd, IntegratesToTheHeightVariance) {
  boost::math::quadrature::exp_sinh<double> to_infinity;

  const RadialPsd k(KCorrelationPsd{1e-7, 0.03, 3.4, 0, kInf});
  EXPECT_NEAR(
      to_infinity.integrate([&](double f) { return f > 0 ? profile_psd(k, f) : 0.0; }, 0.0, kInf, 1e-10) /
          1e-14,
      1, 1e-8);
  const RadialPsd band(PowerLawPsd{1e-7, {}, 2.2, 3, 200});
  const auto s1 = [&](double f) { return profile_psd(band, f); };
  EXPECT_NEAR((integrated(s1, 0.0, 3.0) + integrated(s1, 3.0, 200.0)) / 1e-14, 1, 1e-8);
}

TEST(RandomProfile, MeanVarianceAndPeriodogramAreThoseOfTheProfilePsd) {
  const double pitch = 0.001;
  const int draws = 1500;
  const RadialPsd psd(KCorrelationPsd{1e-7, 0.02, 3.1, 0, 480});
  for (const Eigen::Index n : {24, 25}) {
    const double step = 1 / (double(n) * pitch);
    Eigen::ArrayXd periodogram = Eigen::ArrayXd::Zero(n / 2 + 1);
    Sample variance;
    for (int seed = 0; seed < draws; ++seed) {
      const Profile p = random_profile(psd, n, pitch, {std::uint64_t(seed), 1});
      for (Eigen::Index k = 0; k <= n / 2; ++k) {
        std::complex<double> sum = 0;
        for (Eigen::Index i = 0; i < n; ++i)
          sum += p.value[i] * std::polar(1.0, -2 * pi * double(k * i) / double(n));
        periodogram[k] += 2 * std::norm(sum / double(n)) / step / draws;
      }
      variance.add(p.value.square().mean());
    }

    const auto integral = [&](double a, double b) {
      double sum = 0;
      for (double from = a; from < b;) {
        const double to = from < 480 ? std::min(b, 480.0) : b;
        sum += integrated([&](double f) { return profile_psd(psd, f); }, from, to);
        from = to;
      }
      return sum;
    };
    EXPECT_NEAR(variance.mean(), integral(0.5 * step, 500), 3 * variance.error()) << n;
    EXPECT_LT(periodogram[0], 1e-30 * periodogram.maxCoeff());
    for (Eigen::Index k = 1; k <= n / 2; ++k) {
      const bool own_mirror = 2 * k == n;
      const double high = std::min(double(k) + 0.5, 0.5 * double(n)) * step;
      const double truth = integral((double(k) - 0.5) * step, high) / step * (own_mirror ? 2 : 1);
      EXPECT_NEAR(periodogram[k] / truth, 1, 4 * std::sqrt((own_mirror ? 2.0 : 1.0) / draws))
          << n << " " << k;
    }
  }
}
