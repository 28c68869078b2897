// Tests structure functions. Measured ones are compared with sums over every pair, closed forms and known
// ensembles; those of models with closed forms and direct sums.
#include "aberfit/spectrum/height_differences.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "spectrum/random_line.h"

namespace aberfit {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using test::random_line;
constexpr double kPi = std::numbers::pi;
constexpr double kHole = std::numeric_limits<double>::quiet_NaN();
const DetrendOptions kAsItIs{DetrendShape::kNone, 0};

Profile even(Index n, double pitch) {
  Profile profile;
  profile.x = ArrayXd::LinSpaced(n, 3, 3 + double(n - 1) * pitch);
  profile.value = ArrayXd::Zero(n);
  return profile;
}

// For a sin(2 pi f x): D = 2 a^2 sin^2(pi f s) (1 + mean of cos(4 pi f (x + s/2))). The mean is at most
// 1/(sin(2 pi f pitch) (n - lag)).
TEST(HeightDifferences, OfASinusoidAreTheClosedForm) {
  Profile profile = even(4000, 1e-3);
  constexpr double kAmplitude = 3e-9, kFrequency = 12.37;
  profile.value = kAmplitude * (2 * kPi * kFrequency * profile.x).sin();
  const HeightDifferences d = height_differences(profile, kAsItIs);
  ASSERT_GT(d.separation.size(), 30);
  EXPECT_NEAR(d.separation[0], 1e-3, 1e-12);
  EXPECT_NEAR(d.separation.tail(1)[0], 2, 0.4);
  for (Index k = 0; k < d.separation.size(); ++k) {
    const double largest = 2 * std::pow(kAmplitude * std::sin(kPi * kFrequency * d.separation[k]), 2);
    const double ripple = 1 / (std::sin(2 * kPi * kFrequency * 1e-3) * d.pairs[k]);
    EXPECT_NEAR(d.mean_square[k], largest, (1e-9 + ripple) * largest + 1e-30) << k;
  }
}

TEST(HeightDifferences, OfWhiteNoiseAreTwiceItsVariance) {
  Profile profile = even(20000, 1e-4);
  const RandomStream stream(1, "white noise");
  for (Index i = 0; i < profile.size(); ++i) profile.value[i] = stream.normal(std::uint64_t(i));
  const HeightDifferences d = height_differences(profile, kAsItIs);
  // Of n differences, each shares a point with two others, so the variance of the mean is at most 12/n.
  for (Index k = 0; k < d.separation.size(); ++k)
    EXPECT_NEAR(d.mean_square[k], 2, 4.5 * std::sqrt(12 / d.pairs[k])) << k;
}

TEST(HeightDifferences, CompareOnlyPairsThatAreBothThere) {
  Profile profile = even(60, 2e-3);
  const RandomStream stream(2, "holes of a profile");
  for (Index i = 0; i < profile.size(); ++i)
    profile.value[i] = stream.uniform(std::uint64_t(i)) < 0.3 ? kHole : stream.normal(std::uint64_t(i));
  const HeightDifferences d = height_differences(profile, kAsItIs);
  for (Index k = 0; k < d.separation.size(); ++k) {
    double sum = 0, count = 0;
    for (Index i = 0; i < 60; ++i)
      for (Index j = 0; j < i; ++j)
        if (const double step = profile.value[i] - profile.value[j];
            std::isfinite(step) && std::abs(profile.x[i] - profile.x[j] - d.separation[k]) < 1e-6)
          sum += step * step, ++count;
    EXPECT_EQ(d.pairs[k], count);
    EXPECT_NEAR(d.mean_square[k], sum / count, 1e-12 * sum / count);
  }
  // Samples that the file omits are holes as well.
  Profile shorter;
  std::vector<Index> there;
  for (Index i = 0; i < 60; ++i)
    if (std::isfinite(profile.value[i])) there.push_back(i);
  shorter.x = profile.x(there), shorter.value = profile.value(there);
  const HeightDifferences again = height_differences(shorter, kAsItIs);
  for (Index k = 0; k < std::min(d.separation.size(), again.separation.size()); ++k)
    EXPECT_NEAR(again.mean_square[k], d.mean_square[k], 1e-9 * d.mean_square[k]);
}

// Every pair of points counts once if its distance is within a tenth of the separation, at most half a pitch.
TEST(HeightDifferences, OfAMapAreThoseOfEveryPairInEveryDirection) {
  HeightMap map;
  map.pitch_x = 1e-3, map.pitch_y = 0.8e-3;
  map.height.resize(22, 17);
  const RandomStream stream(3, "holes of a map");
  for (Index i = 0; i < map.height.size(); ++i) {
    const auto [height, other] = stream.normal_pair(std::uint64_t(i));
    map.height.data()[i] = other > 0.8 ? kHole : 1e-8 * height + 1e-6;
  }
  const HeightDifferences d = height_differences(map, {DetrendShape::kPolynomial, 1});
  const HeightMap flat = detrend(map, {DetrendShape::kPolynomial, 1});
  ASSERT_GE(d.separation.size(), 6);
  const double wanted[] = {1, 2, 3, 4, 5, 6, 7, 8};
  for (Index k = 0; k < d.separation.size(); ++k) {
    double sum = 0, count = 0, distance = 0;
    const double reach = std::min(0.5, 0.1 * wanted[k]);
    for (Index a = 0; a < map.height.size(); ++a)
      for (Index b = 0; b < a; ++b) {
        const double s =
            1e3 * std::hypot(map.pitch_x * double(a % 17 - b % 17), map.pitch_y * double(a / 17 - b / 17));
        const double step = flat.height.data()[a] - flat.height.data()[b];
        if (std::isnan(step) || std::abs(s - wanted[k]) > reach) continue;
        sum += step * step, ++count, distance += 1e-3 * s;
      }
    EXPECT_EQ(d.pairs[k], count) << k;
    EXPECT_NEAR(d.separation[k], distance / count, 1e-12) << k;
    EXPECT_NEAR(d.mean_square[k], sum / count, 1e-12 * sum / count) << k;
  }
  map.pitch_x = 0;
  EXPECT_THROW(height_differences(map, kAsItIs), std::invalid_argument);
}

PsdModelFit with_curve(double f_min, double f_max, const test::Spectrum& spectrum) {
  PsdModelFit fit;
  for (const double f : ArrayXd::LinSpaced(400, std::log(f_min), std::log(f_max)).exp().eval()) {
    fit.curve.frequency.push_back(f);
    fit.curve.psd.push_back(spectrum(f));
  }
  return fit;
}

// S1 = A/(1 + (B f)^2) has the autocorrelation pi A/(2 B) exp(-2 pi s/B). The band omits the height variance
// 2 A f_min below it, with a contribution smaller by (2 pi f_min s)^2, and 2 A/(B^2 f_max) above it, twice.
TEST(HeightDifferences, OfAKCorrelationModelAreTheClosedForm) {
  constexpr double kA = 1e-18, kB = 0.02;
  const PsdModelFit fit =
      with_curve(1e-3 / kB, 1e4 / kB, [](double f) { return kA / (1 + kB * kB * f * f); });
  const ArrayXd s = ArrayXd::LinSpaced(12, std::log(0.02 * kB), std::log(3 * kB)).exp();
  const ArrayXd d = model_height_differences(fit, PsdTableKind::k1dOneSided, s);
  for (Index i = 0; i < s.size(); ++i) {
    const double closed = -kPi * kA / kB * std::expm1(-2 * kPi * s[i] / kB);
    const double left_out =
        2 * kA / kB * (1e-4 + 1e-3 * std::min(1.0, std::pow(2 * kPi * 1e-3 * s[i] / kB, 2)));
    EXPECT_NEAR(d[i], closed, 1e-3 * closed + left_out) << i;
  }
}

TEST(HeightDifferences, OfABandedModelAreASum) {
  const auto spectrum = [](double f) { return 1e-15 * std::pow(f, -2.3); };
  const PsdModelFit fit = with_curve(3, 700, spectrum);
  const ArrayXd s = ArrayXd::LinSpaced(9, std::log(1e-4), std::log(2.0)).exp();
  const ArrayXd d = model_height_differences(fit, PsdTableKind::k1dOneSided, s);
  constexpr int kSteps = 400000;  // midpoints in log f
  const double step = std::log(700.0 / 3) / kSteps;
  for (Index i = 0; i < s.size(); ++i) {
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double f = 3 * std::exp((k + 0.5) * step);
      sum += 2 * spectrum(f) * (1 - std::cos(2 * kPi * f * s[i])) * f * step;
    }
    EXPECT_NEAR(d[i], sum, 1e-5 * sum) << i;
  }
}

// For a ring of frequencies: D = 2 sigma^2 (1 - J0(2 pi f s)).
TEST(HeightDifferences, OfAMapsModelGoOverAllDirections) {
  PsdModelFit fit;
  fit.model = UniformPsd{2e-9, 49.9, 50.1};
  const ArrayXd s = ArrayXd::LinSpaced(20, 1e-3, 5e-2);
  const ArrayXd d = model_height_differences(fit, PsdTableKind::k2dTwoSided, s);
  for (Index i = 0; i < s.size(); ++i)
    EXPECT_NEAR(d[i], 8e-18 * (1 - std::cyl_bessel_j(0, 2 * kPi * 50 * s[i])), 1e-4 * 8e-18) << i;
}

// Random lines of a known ensemble: mean of the measured structure functions, and of the fitted ones.
TEST(HeightDifferences, OfRandomLinesAreThoseOfTheirEnsembleAndOfTheirModels) {
  constexpr int kLines = 60;
  const test::Spectrum spectrum = [](double f) { return 1e-18 * std::pow(1 + f * f / 400, -1.5); };
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope}) {
    const PsdEstimator estimator(random_line(spectrum, quantity, 0), {}, 1);
    std::vector<HeightDifferences> found(kLines);
    std::vector<ArrayXd> modelled(kLines);
    parallel_for(found.size(), 2, [&](std::size_t i) {
      const Profile line = random_line(spectrum, quantity, int(i) + 1);
      found[i] = height_differences(line, {});
      const PsdModelFit fit = fit_psd_model(estimator(line));
      modelled[i] = model_height_differences(fit, PsdTableKind::k1dOneSided, found[i].separation);
    });
    const ArrayXd& s = found[0].separation;
    for (Index k = 0; k < s.size() && s[k] < 0.1; ++k) {  // a tenth of the record
      // The trapezoid rule passes only (x cot x)^2, x = pi f pitch, of the highest frequencies of slopes.
      if (quantity == ProfileQuantity::kSlope && s[k] < 3.5 * test::kLinePitch) continue;
      // The ordinates of a line eight times as long are independent.
      double truth = 0;
      for (int j = 1; j < 4 * 1024; ++j) {
        const double f = j / (8 * 1024 * test::kLinePitch);
        truth += 2 * spectrum(f) * (1 - std::cos(2 * kPi * f * s[k])) / (8 * 1024 * test::kLinePitch);
      }
      double mean = 0, square = 0, model = 0;
      for (int i = 0; i < kLines; ++i) {
        const double value = found[std::size_t(i)].mean_square[k] / truth;
        mean += value / kLines, square += value * value / kLines;
        model += modelled[std::size_t(i)][k] / truth / kLines;
      }
      const double error = std::sqrt((square - mean * mean) / kLines);
      // Detrending removes a fraction that grows with s.
      EXPECT_NEAR(mean, 1, 4 * error + 0.03) << s[k] << " quantity " << int(quantity);
      EXPECT_NEAR(model, mean, 0.06) << s[k] << " quantity " << int(quantity);
    }
  }
}

}  // namespace
}  // namespace aberfit
