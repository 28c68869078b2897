#include "aberfit/theory/scatter_function.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/psd_integrals.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kLambda = 550e-9;
const double kInf = std::numeric_limits<double>::infinity();

double rms_of(double g) { return g * kLambda / (4 * pi); }

// 2 pi int BSDF s ds from sine `low` to `high`, on panels between the kinks.
double integral(const ScatterFunction& scatter, double low = 0, double high = 1) {
  std::vector<double> edges{low};
  for (double s = std::max(low, scatter.lowest_sine()); s < high; s *= 1.07) edges.push_back(s);
  const double first = scatter.psd().f_min(), last = std::min(scatter.psd().f_max(), 1 / kLambda);
  std::vector<double> kinks = scatter.psd().breakpoints();
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (const double rounded : {0.99, 1.0, 1.01}) kinks.push_back(rounded * (i * first + j * last));
  for (const double f : kinks)
    if (f * kLambda > low && f * kLambda < high) edges.push_back(f * kLambda);
  edges.push_back(high);
  std::sort(edges.begin(), edges.end());
  const Quadrature rule = gauss_legendre(10, 0, 1);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    for (int j = 0; j < rule.nodes.size(); ++j) {
      const double s = edges[i] + (edges[i + 1] - edges[i]) * rule.nodes[j], theta = std::asin(s);
      // d Omega = 2 pi sin d theta = 2 pi s ds / cos.
      sum += (edges[i + 1] - edges[i]) * rule.weights[j] * 2 * pi * s * scatter.bsdf(theta);
    }
  return sum;
}

TablePsd wavy_table(double rms) {
  TablePsd table;
  for (int i = 0; i <= 20; ++i) {
    table.frequency.push_back(20 * std::pow(10, 4.0 * i / 20));
    table.psd.push_back(std::pow(table.frequency.back(), -2.2) * (1 + 0.5 * std::sin(1.0 * i)));
  }
  const double scale = rms * rms / psd_moments(RadialPsd(table)).height_variance;
  for (double& s : table.psd) s *= scale;
  return table;
}

std::vector<PsdModel> families(double rms) {
  return {UniformPsd{rms, 1000, 3000},
          KCorrelationPsd{rms, 0.3, 2.8, 6, kInf},
          KCorrelationPsd{rms, 1e-4, 3.5, 0, kInf},
          GaussianPsd{rms, 5e-6},
          PowerLawPsd{rms, {}, 2.0, 10, 1e5},
          wavy_table(rms)};
}

}  // namespace

TEST_WITH_SHORT_FORM(ScatterFunction, IntegralOfBsdfOverTheHemisphereIsTis) {
  for (const double g : {0.01, 0.3, 1.0, 2.0, 5.0})
    for (const PsdModel& model : families(rms_of(g))) {
      if (!whole && int(model.index() + 10 * g) % 5 != 0) continue;
      const ScatterFunction scatter(RadialPsd(model), kLambda);
      const std::string what = "family " + std::to_string(model.index()) + ", g " + std::to_string(g);
      // g of the band: roughness above 1/lambda does not scatter.
      const double share = std::exp(-std::pow(4 * pi * scatter.rms_height() / kLambda, 2));
      EXPECT_NEAR(scatter.tis(), 1 - share, 1e-15) << what;
      EXPECT_NEAR(integral(scatter) / scatter.tis(), 1, 1e-7) << what;  // largest seen 7e-9
      EXPECT_EQ(scatter.unresolved(), 0) << what;
      EXPECT_GT(scatter.renormalisation(), 1 - 1e-11) << what;
      EXPECT_LT(scatter.renormalisation(), 1.001) << what;
    }
}

TEST(ScatterFunction, WithinIsTheIntegralUpToThere) {
  for (const PsdModel& model : families(rms_of(1.0))) {
    const ScatterFunction scatter(RadialPsd(model), kLambda);
    for (const double sine : {3e-6, 1.1e-5, 7e-4, 0.02})
      EXPECT_NEAR(integral(scatter, 0, sine), scatter.within(std::asin(sine)), 1e-6) << sine;
    EXPECT_NEAR(scatter.within(pi / 2), scatter.tis(), 1e-14);
    EXPECT_EQ(scatter.within(0), 0);
  }
}

TEST_WITH_SHORT_FORM(ScatterFunction, OfSmoothSurfacesIsRayleighRice) {
  // Per direction-cosine area: (4 pi/lambda)^2 S(sin/lambda) / lambda^2. The rest is of order g^2.
  for (const PsdModel& model : families(1)) {
    double last = 0;
    for (const double g : aberfit::test::all_or_few(whole, std::vector{0.2, 0.1, 0.05, 0.025}, {1, 2})) {
      const RadialPsd psd = RadialPsd(model).scaled(rms_of(g));
      const ScatterFunction scatter(psd, kLambda);
      double worst = 0;
      const double low = std::max(20.0, psd.f_min() * 1.01), high = std::min(2e4, psd.f_max() * 0.99);
      for (int i = 0; i <= 40; ++i) {
        const double f = low * std::pow(high / low, i / 40.0);
        const double first = std::pow(4 * pi / kLambda, 2) * psd(f) / (kLambda * kLambda);
        worst = std::max(worst, std::abs(scatter.bsdf(std::asin(f * kLambda)) / first - 1));
      }
      EXPECT_LT(worst, 10 * g * g) << model.index();
      if (last > 0) {
        EXPECT_NEAR(last / worst, 4, 0.4) << model.index();
      }
      last = worst;
    }
  }
}

TEST(ScatterFunction, BeyondTheBandIsTheSecondOrder) {
  // A uniform disc of frequencies up to F. The second order is half the square of k^2 S times the common area
  // of two discs. Between F and 2 F only the third order adds to it, g^2 of it.
  const double g = 3e-3, F = 2000, s0 = std::pow(rms_of(g), 2) / (pi * F * F), k = 4 * pi / kLambda;
  const ScatterFunction scatter(RadialPsd(UniformPsd{rms_of(g), 0, F}), kLambda);
  for (const double f : {0.0, 0.3, 0.9, 1.1, 1.5, 1.8, 1.95}) {
    const double shared = F * F * (2 * std::acos(f / 2) - f * std::sqrt(1 - f * f / 4));
    const double second = 0.5 * std::pow(k * k * s0, 2) * shared, first = f < 1 ? k * k * s0 : 0;
    const double expected = std::exp(-g * g) * (first + second) / (kLambda * kLambda);
    // Rounded kinks at 0 and 2 F: 4.3e-4 of the second order; elsewhere 1e-5, including the third order.
    EXPECT_NEAR((scatter.bsdf(std::asin(f * F * kLambda)) - expected) * kLambda * kLambda / second, 0,
                f > 0.2 && f < 1.9 ? 3e-5 : 6e-4)
        << f;
  }
}

TEST(ScatterFunction, OfAGaussianIsItsSeries) {
  // C = sigma^2 exp(-(x/l)^2): order n is a Gaussian sqrt(n) as wide, of weight g^2n exp(-g^2)/n!.
  const double l = 2e-4;
  for (const double g : {0.03, 0.5, 2.0, 5.0}) {
    const ScatterFunction scatter(RadialPsd(GaussianPsd{rms_of(g), l}), kLambda);
    const auto series = [&](double f) {
      double sum = 0, weight = std::exp(-g * g);
      for (int n = 1; n < 150; ++n) {
        weight *= g * g / n;
        sum += weight * pi * l * l / n * std::exp(-std::pow(pi * l * f, 2) / n);
      }
      return sum / (kLambda * kLambda);
    };
    for (const double f : {0.0, 300.0, 1000.0, 3000.0, 6000.0}) {
      const double expected = series(f);
      // 1e-11 of the energy per octave, and 1e-9 of the function.
      const double tolerance = 1e-9 * expected + (f > 0 ? 1e-11 / std::pow(f * kLambda, 2) : 0);
      EXPECT_NEAR(scatter.bsdf(std::asin(f * kLambda)), expected, tolerance) << g << " " << f;
    }
  }
}

TEST(ScatterFunction, OfRoughSurfacesIsTheGaussianOfTheirSlopes) {
  // Rays turn by twice the slope: a Gaussian of per-axis standard deviation 2 s. The next term of H at large
  // g, exp(-g^2 r^2) (1 + g^2 r^4 / 2), adds 1/g^2 in the middle.
  double last = 0;
  for (const double g : {5.0, 10.0, 20.0}) {
    const double l = 1e-3;
    const ScatterFunction scatter(RadialPsd(GaussianPsd{rms_of(g), l}), kLambda);
    EXPECT_NEAR(scatter.rms_slope() / (std::numbers::sqrt2 * rms_of(g) / l), 1, 1e-9);
    const double width = 2 * scatter.rms_slope();
    double worst = 0;
    for (const double t : {0.0, 0.5, 1.0, 2.0}) {
      const double gaussian = std::exp(-0.5 * t * t) / (2 * pi * width * width);
      worst = std::max(worst, std::abs(scatter.bsdf(std::asin(t * width)) / gaussian - 1));
    }
    EXPECT_LT(worst, 1.5 / (g * g)) << g;
    if (last > 0) {
      EXPECT_NEAR(last / worst, 4, 0.6) << g;
    }
    last = worst;
  }
}

TEST(ScatterFunction, GoesOnWhereTheVarianceDiverges) {
  // Kolmogorov: H = exp(-a x^(5/3)); in the middle 2 pi int H x dx = 2 pi (3/5) Gamma(6/5) a^(-6/5).
  const double r0 = 1e-3;  // of the reflected wave
  const double s = 0.02289558710855518 * std::pow(r0, -5.0 / 3) * std::pow(kLambda / (4 * pi), 2);
  const ScatterFunction scatter(RadialPsd(PowerLawPsd{{}, s, 11.0 / 3, 0, kInf}), kLambda);
  const double a = 0.5 * 6.883877182 * std::pow(r0, -5.0 / 3);
  const double expected = 2 * pi * 0.6 * std::tgamma(1.2) * std::pow(a, -1.2) / (kLambda * kLambda);
  EXPECT_NEAR(scatter.bsdf(0) / expected, 1, 1e-4);  // the band ends at 1/lambda
  EXPECT_EQ(scatter.tis(), 1);
  EXPECT_NEAR(integral(scatter), 1, 1e-6);
}

TEST(ScatterFunction, MakesUpForOrdersBeyondTheHorizon) {
  // Frequencies up to 1/lambda and g = 1: the second order of a disc reaches 2/lambda.
  const double g = 1, F = 1 / kLambda;
  const ScatterFunction scatter(RadialPsd(UniformPsd{rms_of(g), 0, F}), kLambda);
  EXPECT_GT(scatter.renormalisation(), 1.05);
  EXPECT_NEAR(integral(scatter), 1 - std::exp(-1.0), 1e-6);
  // Without the factor the first order has the energy exp(-g^2) g^2, and the second, g^4/2 exp(-g^2), only
  // the part below the horizon. So the factor is below that of losing all higher orders.
  EXPECT_LT(scatter.renormalisation(), std::expm1(1.0));
  const ScatterFunction half(RadialPsd(UniformPsd{rms_of(g), 0, 2 * F}), kLambda);
  EXPECT_NEAR(half.cut_share(), 0.75, 1e-12);
  EXPECT_NEAR(half.g(), 0.5, 1e-12);
}

TEST(ScatterFunction, OfNothingIsZero) {
  const ScatterFunction scatter(RadialPsd(UniformPsd{1e-9, 100, 200}).band(300, 400), kLambda);
  EXPECT_EQ(scatter.tis(), 0);
  EXPECT_EQ(scatter.bsdf(0.001), 0);
  EXPECT_EQ(scatter.within(1), 0);
  const ScatterTable table = scatter_table(scatter);
  EXPECT_EQ(table.tis_within[table.tis_within.size() - 1], 0);
  EXPECT_EQ(table.bsdf_per_sr.maxCoeff(), 0);
  EXPECT_THROW(ScatterFunction(RadialPsd(PowerLawPsd{{}, 1e-20, 4.5, 0, 1e4}), kLambda), ComputationError);
}

TEST(ScatterTable, InterpolatesToItsPromise) {
  for (const PsdModel& model : families(rms_of(0.5))) {
    const ScatterFunction scatter(RadialPsd(model), kLambda);
    const ScatterTable table = scatter_table(scatter);
    const Eigen::Index rows = table.theta.size();
    EXPECT_EQ(table.theta[0], 0);
    EXPECT_NEAR(table.theta[rows - 1], pi / 2, 1e-15);
    EXPECT_EQ(table.tis_within[rows - 1], scatter.tis());
    EXPECT_EQ(table.asf_per_sr[rows - 1], 0);
    const double least = 1e-4 * table.bsdf_per_sr.maxCoeff();
    double worst = 0, light = pi * std::pow(std::sin(table.theta[1]), 2) * table.bsdf_per_sr[1];
    for (Eigen::Index i = 1; i + 1 < rows; ++i) {
      const double first = table.bsdf_per_sr[i] * std::pow(std::sin(table.theta[i]), 2);
      const double second = table.bsdf_per_sr[i + 1] * std::pow(std::sin(table.theta[i + 1]), 2);
      if (first > 0 && second > 0 && first != second)  // a power of the sine between rows
        light += 2 * pi * (second - first) / std::log(second / first) *
                 std::log(std::sin(table.theta[i + 1]) / std::sin(table.theta[i]));
      EXPECT_GT(table.theta[i], table.theta[i - 1]);
      EXPECT_GE(table.tis_within[i], table.tis_within[i - 1]);
      EXPECT_DOUBLE_EQ(table.asf_per_sr[i], table.bsdf_per_sr[i] * std::cos(table.theta[i]));
      const double one = std::sin(table.theta[i]), two = std::sin(table.theta[i + 1]);
      if (two < one * (1 + 4e-6) || table.bsdf_per_sr[i + 1] < least) continue;  // the two sides of a jump
      const double middle = scatter.bsdf(std::asin(std::sqrt(one * two)));
      worst =
          std::max(worst, std::abs(std::sqrt(table.bsdf_per_sr[i] * table.bsdf_per_sr[i + 1]) / middle - 1));
    }
    EXPECT_LT(worst, 4e-3) << model.index();
  }
}

TEST(ScatterTable, SharpEdgesLieBetweenTwoRows) {
  const double f_min = 50, f_max = 3000;
  const ScatterFunction scatter(RadialPsd(KCorrelationPsd{rms_of(0.2), 0.01, 2.6, f_min, f_max}), kLambda);
  const ScatterTable table = scatter_table(scatter);
  for (const double f : {f_min, f_max}) {
    const double edge = std::asin(f * kLambda);
    const auto above = std::upper_bound(table.theta.begin(), table.theta.end(), edge) - table.theta.begin();
    EXPECT_LT(table.theta[above] - table.theta[above - 1], 3e-6 * edge);
    const double inside = table.bsdf_per_sr[f == f_min ? above : above - 1];
    const double outside = table.bsdf_per_sr[f == f_min ? above - 1 : above];
    const double jump =
        std::exp(-0.04) * std::pow(4 * pi / kLambda, 2) * scatter.psd()(f) / (kLambda * kLambda);
    EXPECT_NEAR((inside - outside) / jump, 1, 1e-3);
  }
}

TEST(ScatterTable, DrawsByItsLastColumnHaveTheMomentsOfTheFunction) {
  // Random angles by the inverse of tis_within / tis, linear in the square of the sine between rows, as in a
  // ray tracer. Reference: the integral of the function, within 4 standard errors.
  const ScatterFunction scatter(RadialPsd(KCorrelationPsd{rms_of(0.8), 0.02, 2.7, 20, 2e5}), kLambda);
  const ScatterTable table = scatter_table(scatter);
  const RandomStream stream(1, "ScatterTable.DrawsByItsLastColumnHaveTheMomentsOfTheFunction");
  const int draws = 200000;
  const std::vector<double> limits{2e-5, 1e-4, 1e-3};
  std::vector<int> below(limits.size());
  for (int i = 0; i < draws; ++i) {
    const double wanted = stream.uniform(std::uint64_t(i)) * table.tis;
    const auto row =
        std::upper_bound(table.tis_within.begin(), table.tis_within.end(), wanted) - table.tis_within.begin();
    const double low = table.tis_within[row - 1], high = table.tis_within[row];
    const double one = std::pow(std::sin(table.theta[row - 1]), 2),
                 two = std::pow(std::sin(table.theta[row]), 2);
    const double sine = std::sqrt(one + (two - one) * (wanted - low) / (high - low));
    for (std::size_t k = 0; k < limits.size(); ++k) below[k] += sine < limits[k];
  }
  for (std::size_t k = 0; k < limits.size(); ++k) {
    const double p = integral(scatter, 0, limits[k]) / scatter.tis();
    EXPECT_GT(p, 0.05);
    EXPECT_LT(p, 0.95);
    EXPECT_NEAR(double(below[k]) / draws, p, 4 * std::sqrt(p * (1 - p) / draws)) << limits[k];
  }
}
