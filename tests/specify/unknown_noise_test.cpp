// Tests the structure of residuals: probabilities for noise alone, and the effect of each systematic error.
#include "../../src/specify/unknown_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <random>

namespace aberfit {
namespace {

using internal::UnknownNoiseResiduals;

constexpr Eigen::Index kData = 24;

Eigen::VectorXd noise(double level, std::mt19937_64* random) {
  std::normal_distribution<double> normal(0, level);
  return Eigen::VectorXd::NullaryExpr(kData, [&]() { return normal(*random); });
}

Eigen::MatrixXd line() {
  Eigen::MatrixXd design(kData, 2);
  design.col(0).setOnes();
  design.col(1).setLinSpaced(kData, -1, 1);
  return design;
}

// Smooth covariance of the deviation of one mirror.
Eigen::MatrixXd smooth_covariance(double size) {
  return Eigen::MatrixXd::NullaryExpr(kData, kData, [&](Eigen::Index i, Eigen::Index j) {
    return size * size * std::exp(-std::pow(double(i - j) / 8, 2));
  });
}

TEST(UnknownNoiseResiduals, LevelOfEvenNoiseIsThatOfTheDegreesOfFreedom) {
  std::mt19937_64 random(1);
  Eigen::VectorXd values = noise(0.003, &random);
  values -= line() * line().colPivHouseholderQr().solve(values);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(kData, kData);
  const Eigen::ArrayXd even = Eigen::ArrayXd::Ones(kData);
  EXPECT_NEAR(
      UnknownNoiseResiduals(values, line(), none, even, 1e-4).level() / (values.norm() / std::sqrt(22.0)), 1,
      1e-4);
  EXPECT_NEAR(UnknownNoiseResiduals(1e-5 * values, line(), none, even, 1e-4).level(), 1e-4, 1e-8);
}

// For noise alone the probabilities are uniform between 0 and 1, with and without a deviation of the mirror.
TEST(UnknownNoiseResiduals, ChancesOfNoiseAloneAreEven) {
  for (const double size : {0.0, 0.01}) {
    const Eigen::MatrixXd own = smooth_covariance(size);
    const Eigen::MatrixXd root =
        Eigen::MatrixXd(own + 1e-14 * Eigen::MatrixXd::Identity(kData, kData)).llt().matrixL();
    std::mt19937_64 random(2);
    int below = 0, far_below = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Eigen::VectorXd values = noise(0.002, &random) + root * noise(1, &random);
      const UnknownNoiseResiduals residuals(values, line(), own, Eigen::ArrayXd::Ones(kData), 1e-4);
      const double chance = residuals.chance(internal::smooth_columns(kData));
      below += chance < 0.5, far_below += chance < 0.02;
    }
    EXPECT_NEAR(below / double(kTrials), 0.5, 0.13) << size;
    EXPECT_LE(far_below, 12) << size;
  }
}

// A bow of three standard deviations of the noise is an error for a mean, but not for one mirror.
TEST(UnknownNoiseResiduals, ABowIsAFaultUnlessMirrorsHaveIt) {
  std::mt19937_64 random(3);
  const Eigen::VectorXd bow = line().col(1).array().square().matrix();
  const Eigen::VectorXd values = noise(0.002, &random) + 0.012 * bow;
  const Eigen::ArrayXd even = Eigen::ArrayXd::Ones(kData);
  const UnknownNoiseResiduals of_mean(values, line(), Eigen::MatrixXd::Zero(kData, kData), even, 1e-4);
  EXPECT_LT(of_mean.chance(bow), 1e-4);
  EXPECT_LT(of_mean.chance(internal::smooth_columns(kData)), 1e-2);
  EXPECT_EQ(of_mean.chance(2 * line().col(1)), 1);  // adds nothing new
  EXPECT_GT(UnknownNoiseResiduals(values, line(), smooth_covariance(0.02), even, 1e-4).chance(bow), 0.02);
  const internal::ResidualVerdict verdict = verdict_of(
      of_mean, {{"line", line().col(1)}, {"bow", bow}, {"smooth", internal::smooth_columns(kData)}}, 0.02);
  EXPECT_EQ(verdict.remedy, "bow");
  EXPECT_LT(verdict.chance, 1e-3);
}

// A mistake in one datum is not reported as a bow, although a bow explains part of it.
TEST(UnknownNoiseResiduals, OneDatumFarOffIsNamed) {
  for (const Eigen::Index datum : {0, 9, 23}) {
    std::mt19937_64 random(4);
    Eigen::VectorXd values = noise(0.002, &random);
    values[datum] += 0.03;
    const UnknownNoiseResiduals residuals(values, line(), Eigen::MatrixXd::Zero(kData, kData),
                                          Eigen::ArrayXd::Ones(kData), 1e-4);
    EXPECT_EQ(residuals.farthest(), datum);
    Eigen::VectorXd bump = Eigen::VectorXd::Zero(kData);
    for (Eigen::Index k = 0; k < kData; ++k) bump[k] = std::exp(-std::pow(double(k - datum), 2));
    const internal::ResidualVerdict verdict =
        verdict_of(residuals, {{"bump", bump}, {"smooth", internal::smooth_columns(kData)}}, 0.02);
    EXPECT_LT(verdict.chance, 0.02) << datum;
    ASSERT_TRUE(verdict.datum.has_value()) << datum;
    EXPECT_EQ(*verdict.datum, datum);
  }
}

}  // namespace
}  // namespace aberfit
