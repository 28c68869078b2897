#include "aberfit/theory/abg_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kLambda = 550e-9;
const double kInf = std::numeric_limits<double>::infinity();

double rms_of(double g) { return g * kLambda / (4 * pi); }

// 2 pi int s a / (b + s^g) ds by Simpson's rule in log s.
double light_within(const AbgModel& m, double sine) {
  const int n = 20000;
  const double low = std::log(1e-12), step = (std::log(sine) - low) / n;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double s = std::exp(low + i * step);
    sum += (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2) * s * s * m.a / (m.b + std::pow(s, m.g));
  }
  return 2 * pi * sum * step / 3;
}

}  // namespace

TEST(AbgModel, LightWithinIsTheIntegral) {
  for (const AbgModel& m :
       {AbgModel{0.1, 0.5, 0}, AbgModel{1e-3, 1e-4, 1.3}, AbgModel{1e-6, 1e-8, 2},
        AbgModel{1e-6, 1e-8, 2 + 1e-9}, AbgModel{1e-9, 1e-12, 2.8}, AbgModel{1e-9, 1e-10, 5}})
    for (const double theta : {1e-4, 0.03, 0.5 * pi})
      EXPECT_NEAR(m.within(theta) / light_within(m, std::sin(theta)), 1, 1e-9) << m.g << " " << theta;
  EXPECT_EQ(AbgModel{}.within(1), 0);
  EXPECT_EQ((AbgModel{2, 0.5, 1}.bsdf(0)), 4);
  EXPECT_DOUBLE_EQ((AbgModel{2, 0.5, 1}.bsdf(pi / 6)), 2);
}

TEST(AbgFit, RecoversAnExactModel) {
  // S of the 2-D exponent 2 in single scattering: BSDF = k^2 S0 / lambda^2 / (1 + (B s/lambda)^2). So a = k^2
  // S0 / B^2, b = (lambda/B)^2, g = 2, but for the higher orders, of relative size g^2.
  const double g = 1e-3, B = 1e-3;
  const RadialPsd psd(KCorrelationPsd{rms_of(g), B, 2, 0, 1e6});
  const ScatterFunction scatter(psd, kLambda);
  const AbgFit fit = fit_abg(scatter);
  ASSERT_TRUE(fit.found);
  const double a = std::pow(4 * pi / kLambda, 2) * psd(0) / (B * B), b = std::pow(kLambda / B, 2);
  EXPECT_NEAR(fit.model.a / a, 1, 20 * g * g);
  EXPECT_NEAR(fit.model.b / b, 1, 20 * g * g);
  EXPECT_NEAR(fit.model.g, 2, 10 * g * g);
  EXPECT_LT(fit.largest_error, 10 * g * g);
  EXPECT_FALSE(fit.at_least_b);
  EXPECT_NEAR(fit.model_in_range / fit.light_in_range, 1, 1e-4);
  // pi a log(1 + 1/b), although S ends at 1e6 /m.
  EXPECT_NEAR(fit.tis / (pi * a * std::log1p(1 / b)), 1, 1e-4);
}

TEST(AbgFit, StatesTheErrorThatItHas) {
  for (const double g : {0.05, 1.0, 3.0}) {
    const ScatterFunction scatter(RadialPsd(KCorrelationPsd{rms_of(g), 1e-3, 3.4, 0, kInf}), kLambda);
    const AbgFit fit = fit_abg(scatter);
    ASSERT_TRUE(fit.found);
    double largest = 0, squares = 0;
    const int n = 3001;
    const double low = std::sin(fit.theta_min), high = std::sin(fit.theta_max);
    for (int i = 0; i < n; ++i) {
      const double theta = std::asin(low * std::pow(high / low, i / (n - 1.0)));
      const double ratio = std::log(fit.model.a / (fit.model.b + std::pow(std::sin(theta), fit.model.g)) /
                                    scatter.bsdf(theta));
      largest = std::max(largest, std::abs(ratio));
      squares += ratio * ratio;
    }
    // 400 samples against 3001: the largest error lies between two of them, and the ends have other weights.
    EXPECT_NEAR(fit.largest_error / std::expm1(largest), 1, 0.01) << g;
    EXPECT_NEAR(fit.rms_error / std::expm1(std::sqrt(squares / n)), 1, 0.02) << g;
    EXPECT_GT(fit.largest_error, 0.05) << g;  // the shape is not quite an ABg model
    EXPECT_LT(fit.largest_error, 0.6) << g;
    EXPECT_NEAR(fit.tis / light_within(fit.model, 1), 1, 1e-8) << g;
    EXPECT_NEAR(fit.light_in_range, scatter.within(fit.theta_max) - scatter.within(fit.theta_min), 1e-12);
  }
}

TEST(AbgFit, IsTheLeastOfItsNeighbours) {
  const ScatterFunction scatter(RadialPsd(KCorrelationPsd{rms_of(0.5), 1e-3, 2.7, 0, kInf}), kLambda);
  const AbgFit fit = fit_abg(scatter);
  const auto cost = [&](double log_b, double g) {
    double sum = 0, squares = 0;
    const int n = 400;
    for (int i = 0; i < n; ++i) {
      const double low = std::sin(fit.theta_min), high = std::sin(fit.theta_max);
      const double s = low * std::pow(high / low, i / (n - 1.0));
      const double r = std::log(scatter.bsdf(std::asin(s)) * (std::exp(log_b) + std::pow(s, g)));
      sum += r;
      squares += r * r;
    }
    return squares - sum * sum / n;
  };
  const double best = cost(std::log(fit.model.b), fit.model.g);
  for (const double by_b : {-1e-3, 0.0, 1e-3})
    for (const double by_g : {-1e-4, 0.0, 1e-4})
      if (by_b != 0 || by_g != 0) {
        EXPECT_GT(cost(std::log(fit.model.b) + by_b, fit.model.g + by_g), best) << by_b << " " << by_g;
      }
}

TEST(AbgFit, RangeEndsWhereTheBandDoes) {
  const ScatterFunction scatter(RadialPsd(KCorrelationPsd{rms_of(0.1), 0.3, 2.8, 6, 200}), kLambda);
  const AbgFit fit = fit_abg(scatter);
  EXPECT_GE(std::sin(fit.theta_min), 6 * kLambda);
  EXPECT_LE(std::sin(fit.theta_max), 200 * kLambda);
  EXPECT_TRUE(fit.at_least_b);  // the knee lies at 2e-6, and b at 1e-12 shows no knee below 3e-6
  EXPECT_EQ(fit.model.b, 1.01e-12);
  AbgOptions any;
  any.least_b = 1e-30;
  const AbgFit free = fit_abg(scatter, any);
  EXPECT_FALSE(free.at_least_b);
  EXPECT_LT(free.largest_error, 0.1 * fit.largest_error);
  // Beyond the range the model scatters more than the mirror.
  EXPECT_GT(free.tis, 1.2 * scatter.tis());
  EXPECT_NEAR(free.model_in_range / free.light_in_range, 1, 0.01);

  // At g = 5 the scatter has left the band, and the range with it.
  const ScatterFunction rough(RadialPsd(UniformPsd{rms_of(5), 100, 200}), kLambda);
  EXPECT_GT(std::sin(fit_abg(rough).theta_max), 500 * kLambda);
  // A very narrow band keeps its range.
  const ScatterFunction line(RadialPsd(UniformPsd{rms_of(0.3), 1000, 1001}), kLambda);
  const AbgFit of_line = fit_abg(line);
  EXPECT_GT(std::sin(of_line.theta_min), 1000 * kLambda);
  EXPECT_LT(std::sin(of_line.theta_max), 1001 * kLambda);
  EXPECT_LT(of_line.largest_error, 0.01);

  AbgOptions narrow;
  narrow.theta_min = 1e-5;
  narrow.theta_max = 5e-5;
  const AbgFit part = fit_abg(scatter, narrow);
  EXPECT_DOUBLE_EQ(part.theta_min, 1e-5);
  EXPECT_DOUBLE_EQ(part.theta_max, 5e-5);
  EXPECT_LT(part.rms_error, fit.rms_error);
}

TEST(AbgFit, RefusesWhatItCannotFit) {
  const ScatterFunction scatter(RadialPsd(UniformPsd{rms_of(0.1), 100, 1000}), kLambda);
  AbgOptions options;
  options.theta_min = 0.2;
  options.theta_max = 0.1;
  EXPECT_THROW(fit_abg(scatter, options), std::invalid_argument);
  options.theta_max = 2;
  EXPECT_THROW(fit_abg(scatter, options), std::invalid_argument);
  EXPECT_FALSE(fit_abg(ScatterFunction(RadialPsd(UniformPsd{1e-9, 1, 2}).band(3, 4), kLambda)).found);
  const AbgFit flat = fit_abg(scatter);  // a plateau has no knee and almost no exponent
  EXPECT_LT(flat.largest_error, 0.01);
}
